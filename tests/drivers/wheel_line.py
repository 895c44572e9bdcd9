"""A driver of wheels and the emulated controller on a line in memory, in the test's own time."""

from typing import Any

from lbr.capability.context import Device
from lbr.drivers.roboteq import KIND, RoboteqSettings
from lbr.drivers.roboteq.controller import Controller
from lbr.drivers.wheels.capability import Wheels
from lbr.messages.motors import MotorSetpoint
from lbr.simulation.devices.roboteq.device import RoboteqDevice
from lbr.testing import FakeContext
from tests.drivers.memory_line import MemoryLine

STEP_S = 1.0 / Wheels.rate_hz
DEVICE = Device("motors", "roboteq", "memory", {})


class AnsweringLine:
    """A line on which each command is answered alike."""

    def __init__(self, answer: bytes) -> None:
        self.answer = answer
        self.written: list[bytes] = []

    def write(self, data: bytes) -> int:
        self.written.append(data)
        return len(data)

    def read(self, wait_s: float = 0.0) -> bytes:
        del wait_s
        return self.answer

    def close(self) -> None:
        pass


class MemoryWheels(Wheels[RoboteqSettings]):
    """The driver on that line; a controller that was once opened stays as it is."""

    def __init__(self, ctx: FakeContext) -> None:
        super().__init__(ctx)
        self.line = MemoryLine(RoboteqDevice(), ctx)

    def connect(self, device: Device, beat: Any) -> Controller:
        del device
        return Controller(self.line, self.ctx.settings, self.ctx.clock, beat)


class GuardPipe:
    """What a driver tells its guard, whose process a test is."""

    newest: "GuardPipe"

    def __init__(self, line: int, stop: Any, silence_ms: int, clock: Any) -> None:
        self.told, self.clock = (line, stop, silence_ms), clock
        self.listens = self.standing = True
        self.was_frozen = False
        self.beats: list[bool] = []
        self.first_turning_at: float | None = None
        self.last: list[str] = []
        GuardPipe.newest = self

    def woken(self) -> bool:
        was, self.was_frozen = self.was_frozen, False
        return was

    def beat(self, *, turning: bool) -> None:
        self.beats.append(turning)
        if turning and self.first_turning_at is None:
            self.first_turning_at = self.clock()

    def dismiss(self) -> None:
        self.last.append("dismissed")

    def speak(self) -> None:
        self.last.append("spoke")


class WheelBench:
    """A driver with a source, `drive`, that it is wired to; `step` lets a tick of the loop go by."""

    def __init__(self, settings: str = '"guard": false') -> None:
        row = KIND.parse(f'{{"device": "motors", {settings}}}')
        self.ctx = FakeContext(KIND, row, robot="tester", device=DEVICE)
        self.ctx.wired["setpoint"] = ("drive",)
        self.motors = MemoryWheels(self.ctx)
        self.line = self.motors.line

    @property
    def state(self) -> Any:
        return self.ctx.published[-1][1]

    @property
    def outputs(self) -> tuple[float, float]:
        """The power that the controller gives its motors."""
        return self.line.device.outputs(self.ctx.now)

    def written(self, since_s: float = 0.0) -> list[str]:
        """The commands to the controller's motors, and to its emergency stop."""
        return [data.decode().strip() for at, data in self.line.written if at >= since_s and data[:1] == b"!"]

    def give(self, left: float, right: float | None = None, lease: str = "L1", *, source: str = "drive") -> None:
        right = left if right is None else right
        self.ctx.arrive("setpoint", MotorSetpoint(left=left, right=right, lease=lease), source=source)

    def step(self, passed_s: float = STEP_S) -> None:
        """Step once, so long after the last step began."""
        self.ctx.now = max(self.ctx.now, getattr(self, "began", self.ctx.now) + passed_s)
        self.began = self.ctx.now
        self.motors.step()

    def steps(self, seconds: float, power: float | None = None, lease: str = "L1") -> None:
        """Step for a while, on fresh setpoints if there is a power."""
        for _ in range(round(seconds / STEP_S)):
            if power is not None:
                self.give(power, lease=lease)
            self.step()

    def drive(self, power: float = 0.5, lease: str = "L1") -> None:
        """Arm, and turn the wheels."""
        self.steps(2 * STEP_S, 0.0, lease)
        self.steps(2 * STEP_S, power, lease)
