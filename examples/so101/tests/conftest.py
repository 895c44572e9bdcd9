"""The common part of the tests: the twin on a pty, with the driver. They need the package installed beside lbr."""

import time

import pytest
from lbr_so101.kind import KIND

from lbr.messages.joints import Joint
from lbr.messages.servos import ServoGoal, ServoSetpoint
from lbr.testing.device import plugged
from lbr.testing.driver import DriverBench

IDS = (1, 2, 3, 4, 5, 6)
NAMES = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll", "gripper")
ROWS = tuple(
    Joint(name=name, device_id=number, lower_rad=-1.6, upper_rad=1.6, speed_rps=3.0)
    for number, name in enumerate(NAMES, 1)
)
SETTINGS = '{"device": "arm", "guard": false, "reply_margin_s": 0.03, "setpoint_valid_s": 0.25, "hold_s": 0.3, "release_s": 0.3}'


class Arm(DriverBench):
    """The driver beside its twin, and a sender that repeats its goals until they change.

    A busy machine may delay the test for longer than a setpoint lives, which ends the motion: then the sender begins
    another.
    """

    def __init__(self, device, settings=SETTINGS):
        super().__init__(KIND, settings, device, wired={"setpoint": ("joints",)}, given=ROWS, name="arm")
        self.twin = device.twin
        self.servos = device.twin.servos
        self.goals = None
        self._motions = 1

    def until(self, condition, what):
        def step():
            if self.goals is not None:
                if self.state is not None and "has died" in self.state.reason:
                    self._motions += 1
                setpoint = ServoSetpoint(goals=self.goals, lease=f"motion {self._motions}")
                self.ctx.arrive("setpoint", setpoint, source="joints")
            return condition()

        super().until(step, what)

    def send(self, **goal):
        self.goals = tuple(ServoGoal(id=number, **goal) for number in IDS)

    def on(self, **goal):
        """Give every servo torque and a goal, and wait until the driver knows."""
        self.send(**goal)
        self.until(lambda: all(self.torques()) and self.each(lambda one: one.torque and not one.reason), "torque")

    def torques(self):
        return [servo.torque for servo in self.servos.values()]

    @property
    def state(self):
        states = self.ctx.said("state")
        return states[-1] if states else None

    def seen(self, number):
        return next((one for one in self.state.servos if one.id == number), None) if self.state else None

    def reason(self, number):
        """Return a servo's fault; empty, too, while its first looks are under way."""
        seen = self.seen(number)
        return seen.reason if seen else ""

    def each(self, check):
        return self.state is not None and len(self.state.servos) == len(IDS) and all(map(check, self.state.servos))

    def steps(self, seconds):
        """Step for a while."""
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() > end, "time")


@pytest.fixture
def device(tmp_path, request):
    with plugged("feetech", tmp_path, name="arm", settings=getattr(request, "param", None)) as found:
        yield found


@pytest.fixture
def arm(device):
    arm = Arm(device)
    yield arm
    arm.close()
