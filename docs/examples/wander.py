"""A capability of your own: drives about, and turns away from what is near. Copy it to `$LBR_HOME/capabilities/`.

It moves as anybody does: it asks the drive for a motion, and repeats what it asked with the lease it was given. Once
somebody stops the robot or takes it over, it rests until it is told to start again.
"""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability import Asked, Call, Capability, Kind
from lbr.messages.drive import DriveCommand
from lbr.messages.leases import CommandReply
from lbr.messages.sensing import Ranges

RENEW_S = 0.1


class WanderSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row of kind `wander` may set."""

    power: Annotated[float, Meta(gt=0.0, le=0.5)] = 0.25
    turn_at_m: Annotated[float, Meta(ge=0.4, le=3.0, description="turns when something ahead is nearer")] = 0.9


class Start(Struct, frozen=True):
    """Begin to wander."""


class Wander(Capability[WanderSettings]):
    """Ahead while there is room, otherwise to the right on the spot."""

    rate_hz = 20.0
    _wandering = False
    _lease = ""
    _renew_at = 0.0
    _asked: Asked | None = None

    def command(self, call: Call) -> None:
        """Begin."""
        self._wandering = True
        self._lease = ""
        call.reply(CommandReply(accepted=True, reason="wandering until somebody stops the robot"))

    def step(self) -> None:
        """Hear what the drive answered, and ask again in time."""
        if self._asked is not None:
            self._hear(self._asked)
        if self._wandering and self._asked is None and self.ctx.clock() >= self._renew_at:
            self._renew_at = self.ctx.clock() + RENEW_S
            wanted = DriveCommand(power=self.ctx.settings.power, angle_deg=self._angle_deg(), lease=self._lease)
            self._asked = self.ctx.ask("go", wanted, timeout_s=0.3)

    def _hear(self, asked: Asked) -> None:
        answers = asked.answers()
        if answers is None:
            return
        self._asked = None
        answer = next(iter(answers.values()), None)
        if isinstance(answer, CommandReply) and answer.accepted:
            self._lease = answer.lease
        else:
            self._wandering = False
            why = answer.reason if isinstance(answer, CommandReply) else "no answer"
            self.ctx.event("wander", f"rests: {why}")

    def _angle_deg(self) -> float:
        ranges = self.ctx.latest("ranges")
        if ranges is None or ranges.age_s(self.ctx.clock()) > RENEW_S * 3:
            return 90.0
        room_m = ranges.message.forward_m
        free = ranges.message.status.get("forward") == "over_range"
        return 0.0 if free or (room_m is not None and room_m > self.ctx.settings.turn_at_m) else 90.0


KIND = Kind(
    name="wander",
    summary="drives about and turns away from what is near",
    family="app",
    entry=Wander,
    settings=WanderSettings,
    inputs={"ranges": Ranges},
    commands={"start": Start},
    requests={"go": DriveCommand},
    replies={"start": CommandReply, "go": CommandReply},
)
