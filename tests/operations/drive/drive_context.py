"""A robot around one drive capability, for tests: what it hears is set by hand, what it says is kept."""

from typing import Any

from lbr.capability.context import Received
from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand
from lbr.messages.leases import StopCommand
from lbr.operations.drive.settings import DriveSettings
from tests.operations.drive.drive_bench import motors, ranges
from tests.operations.fakes import FakeAsked, FakeCall, FakeEstop


class FakeContext:
    """What the runtime gives a capability, without a bus."""

    robot, name, device, devices = "robot", "drive", None, ()

    def __init__(self, **settings):
        self.settings = DriveSettings(**settings)
        self.estop = FakeEstop()
        self.now = 50.0
        self.published: list[tuple[str, Any]] = []
        self.events: list[tuple[str, str]] = []
        self.data: list[dict[str, Any] | None] = []
        self.asked: list[FakeAsked] = []
        self.checks: dict[str, Any] | None = {}
        self.drivers_alive = True
        self.gone: set[str] = set()
        self._latest: dict[str, Received] = {}
        self._arrived: dict[str, list[Received]] = {}

    def clock(self):
        return self.now

    def publish(self, output, message):
        self.published.append((output, message))

    def latest(self, port):
        return self._latest.get(port)

    def take(self, port):
        return self._arrived.pop(port, [])

    def sources(self, port):
        return (port,)

    def alive(self, capability):
        return self.drivers_alive and capability not in self.gone

    def ask(self, request, message, timeout_s):
        self.asked.append(FakeAsked(message, self.checks))
        return self.asked[-1]

    def event(self, kind, text, *, level="info", data=None, code="", about=""):
        self.events.append((kind, text))
        self.data.append(data)

    def hear(self, *, armed=True, **metres):
        self._latest["motors"] = Received(
            motors(armed=armed, reason="" if armed else "tripped"), None, self.now, "motors"
        )
        self.arrive("ranges", ranges(**metres))

    def arrive(self, port, message):
        self._arrived.setdefault(port, []).append(Received(message, None, self.now, port))

    def said(self, output):
        return [message for name, message in self.published if name == output]

    def command(self, power, angle_deg=0.0, *, source="console", **more):
        return FakeCall("command", DriveCommand(power=power, angle_deg=angle_deg, **more), self.now, source)

    def turn(self, angle_deg, **more):
        return FakeCall("turn", TurnCommand(angle_deg=angle_deg, **more), self.now)

    def head(self, heading_deg, **more):
        return FakeCall("heading", HeadingCommand(heading_deg=heading_deg, **more), self.now)

    def stop(self, source="phone"):
        return FakeCall("stop", StopCommand(reason="test"), self.now, source)
