"""A capability of your own: drives about, and turns away from what is near. Copy it to `$LBR_HOME/capabilities/`.

It moves as anybody does: it borrows the drive, and its lease is kept for it. When that ends, because the robot was
stopped or taken over, it rests until it is told to start again.
"""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability import Call, Capability, Kind, LeaseClient, LeaseTarget
from lbr.messages.drive import DriveCommand
from lbr.messages.leases import CommandReply
from lbr.messages.sensing import Ranges

DRIVE = LeaseTarget("go", kind="drive")
OLDEST_S = 0.3


class WanderSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `wander`."""

    power: Annotated[float, Meta(gt=0.0, le=0.5)] = 0.25
    turn_at_m: Annotated[float, Meta(ge=0.4, le=3.0, description="turns when something ahead is nearer")] = 0.9


class Start(Struct, frozen=True):
    """Begin to wander."""


class Wander(Capability[WanderSettings]):
    """Ahead while there is room, otherwise to the right on the spot."""

    rate_hz = 20.0
    _lease: LeaseClient | None = None

    def command(self, call: Call) -> None:
        """Begin, with a lease of the drive."""
        self._lease = self._lease or LeaseClient(self.ctx, DRIVE, self._wanted())
        call.reply(CommandReply(accepted=True, reason="wandering until the robot is stopped"))

    def step(self) -> None:
        """Go on while the lease lives."""
        if self._lease is None:
            return
        self._lease.step()
        self._lease.keep(self._wanted())
        if self._lease.ended:
            self.ctx.event("wander", f"rests: {self._lease.ended}", code=self._lease.ended.code)
            self._lease = None

    def _wanted(self) -> DriveCommand:
        return DriveCommand(power=self.ctx.settings.power, angle_deg=self._angle_deg())

    def _angle_deg(self) -> float:
        ranges = self.ctx.latest("ranges")
        if ranges is None or ranges.age_s(self.ctx.clock()) > OLDEST_S:
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
