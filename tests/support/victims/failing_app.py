"""An app that drives under a lease of its own, and goes wrong when told to."""

import sys
from pathlib import Path

from msgspec import Struct

sys.path.insert(0, str(Path(__file__).parent))

from failures import Fail, fail  # type: ignore[import-not-found]

from lbr.capability.base import Capability
from lbr.capability.context import Call, Context, PendingReply
from lbr.capability.kind import Kind
from lbr.messages.drive import DriveCommand
from lbr.messages.leases import CommandReply

RENEW_S = 0.1


class AppSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`note` changes nothing but the row."""

    note: str = ""


class Go(Struct, frozen=True, kw_only=True):
    """Drive until told otherwise."""

    angle_deg: float
    power: float = 0.4


class FailingApp(Capability[AppSettings]):
    rate_hz = 50.0

    def __init__(self, ctx: Context[AppSettings]) -> None:
        super().__init__(ctx)
        self._go: Go | None = None
        self._lease = ""
        self._asked: PendingReply | None = None
        self._due = 0.0

    def step(self) -> None:
        answers = self._asked.answers() if self._asked else None
        if answers is not None:
            self._asked = None
            reply = answers.get("drive")
            self._lease = reply.lease if reply is not None and reply.accepted else ""
        if self._go is not None and self._asked is None and self.ctx.clock() >= self._due:
            self._due = self.ctx.clock() + RENEW_S
            command = DriveCommand(power=self._go.power, angle_deg=self._go.angle_deg, lease=self._lease)
            self._asked = self.ctx.ask("move", command, timeout_s=0.2)

    def command(self, call: Call) -> None:
        call.reply(CommandReply(accepted=True))
        if isinstance(call.message, Fail):
            fail(call.message.how, f"{self.ctx.home}/run/{self.ctx.robot}.sock")
        elif isinstance(call.message, Go):
            self._go = call.message if call.message.power > 0.0 else None


KIND = Kind(
    name="failing_app",
    summary="drives, and goes wrong when told to",
    family="app",
    entry=FailingApp,
    settings=AppSettings,
    commands={"go": Go, "fail": Fail},
    replies={"go": CommandReply, "fail": CommandReply, "move": CommandReply},
    requests={"move": DriveCommand},
)
