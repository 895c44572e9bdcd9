"""A robot around one drive capability, for tests: what it hears is set by hand, what it says is kept."""

from typing import Any

from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand
from lbr.messages.leases import StopCommand
from lbr.messages.sensing import ring
from lbr.operations.drive import KIND
from lbr.operations.drive.settings import DriveSettings
from lbr.testing import FakeCall, FakeContext
from tests.operations.drive.drive_bench import motors, ranges


class DriveContext(FakeContext):
    """The context of a drive: `hear` is what motors and ranges say, `checks` what others say of each command."""

    def __init__(self, **settings):
        super().__init__(KIND, DriveSettings(**settings), name="drive", given=ring(0.43, 0.30))
        self.checks: dict[str, Any] | None = {}
        self.drivers_alive = True

    def answer(self, request, message):
        return self.checks

    def alive(self, capability):
        return self.drivers_alive and super().alive(capability)

    def hear(self, *, armed=True, **metres):
        self.arrive("motors", motors(armed=armed, reason="" if armed else "tripped"))
        self.arrive("ranges", ranges(**metres))

    def command(self, power, angle_deg=0.0, *, source="console", **more):
        return FakeCall("command", DriveCommand(power=power, angle_deg=angle_deg, **more), self.now, source)

    def turn(self, angle_deg, **more):
        return FakeCall("turn", TurnCommand(angle_deg=angle_deg, **more), self.now)

    def head(self, heading_deg, **more):
        return FakeCall("heading", HeadingCommand(heading_deg=heading_deg, **more), self.now)

    def stop(self, source="phone"):
        return FakeCall("stop", StopCommand(reason="test"), self.now, source)
