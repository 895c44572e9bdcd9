"""A robot in one thread, faster than real time: physics, inertial unit, attitude and drive kernel, tick by tick."""

from collections import deque
from math import degrees
from random import Random

import numpy as np
from msgspec.structs import replace

from lbr.leases.lease import Result
from lbr.messages.drive import GoalResult, HeadingCommand, TurnCommand
from lbr.messages.imu import ImuSample
from lbr.messages.motors import MotorsState
from lbr.messages.sensing import Ranges
from lbr.operations.attitude.compass import MATRIX, OFFSETS
from lbr.operations.attitude.fusion import Fusion
from lbr.operations.attitude.settings import AttitudeSettings
from lbr.operations.drive.kernel import decide, first_state
from lbr.operations.drive.settings import DriveSettings
from lbr.operations.drive.state import AttitudeSeen, Command, Event, MotorsSeen, RangesSeen, Tick
from lbr.simulation.engine import Engine
from lbr.simulation.settings import Imu, WorldSettings

STEP_S = 0.01
TICK_STEPS, RENEW_STEPS, FIELD_STEPS = 2, 10, 10
WAY_TICKS = (1, 2)
"""A setpoint is in force this many ticks later: bus, driver, controller."""
SETTLE_S = 2.0
LONGEST_S = 40.0
FREE = Ranges(
    forward_m=None,
    back_m=None,
    left_m=None,
    right_m=None,
    bottom_m=None,
    status=dict.fromkeys(("forward", "back", "left", "right", "bottom"), "over_range"),
)
ARMED = MotorsState(left=0.0, right=0.0, armed=True, reason="", estop=False)


class Plant:
    """The world, and the truth about how far the base has turned in it (degrees, clockwise)."""

    def __init__(self, seed: int) -> None:
        self.engine = Engine(WorldSettings(walls=(), seed=seed))
        self.now = 100.0
        self.turned_deg = 0.0
        self._yaw_deg = degrees(self.engine.pose().yaw_rad)

    @property
    def heading_deg(self) -> float:
        """Where it looks, clockwise from north, which is where it looked at first."""
        return -self._yaw_deg % 360.0

    def step(self, left: float, right: float) -> None:
        """Let a hundredth of a second pass."""
        self.engine.step(left, right, STEP_S)
        self.now += STEP_S
        yaw_deg = degrees(self.engine.pose().yaw_rad)
        self.turned_deg -= (yaw_deg - self._yaw_deg + 180.0) % 360.0 - 180.0
        self._yaw_deg = yaw_deg

    def sample(self, *, field: bool) -> ImuSample:
        """Return what the inertial unit measures now."""
        read = self.engine.imu()
        return ImuSample(
            valid=True,
            time_s=self.now,
            gyro_rps=read.gyro_rps,
            accel_mps2=read.accel_mps2,
            mag_ut=read.mag_ut if field else None,
        )


class Robot:
    """The robot: attitude by fusion, turns by the drive kernel, and somebody who renews what they asked for."""

    def __init__(self, seed: int) -> None:
        self.plant = Plant(seed)
        self.results: list[GoalResult] = []
        settings = AttitudeSettings(device="imu")
        self._fusion = Fusion(settings, _calibrated(Imu()), f"seed {seed}")
        self._state_steps = round(1 / settings.publish_hz / STEP_S)
        self.settings = DriveSettings()
        self._drive = first_state(self.settings)
        self._dice = Random(seed)
        self._under_way: deque[tuple[float, float]] = deque([(0.0, 0.0)])
        self._steps = 0
        self._commands = 0
        self.rest(SETTLE_S)

    def rest(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(seconds / STEP_S)):
            self._step()

    def turn(self, asked: TurnCommand | HeadingCommand) -> GoalResult | None:
        """Ask for a turn and renew it until it has ended; None if it never does."""
        self._commands += 1
        name, ends = f"G{self._commands}", self.plant.now + LONGEST_S
        self._say(asked, name)
        while self.plant.now < ends:
            self._step()
            if self.results and self.results[-1].goal == name:
                return self.results[-1]
            if self._steps % RENEW_STEPS == 0 and self._drive.lease is not None:
                self._say(replace(asked, lease=self._drive.lease.id), name)
        return None

    def _step(self) -> None:
        self.plant.step(*self._under_way[0])
        self._steps += 1
        sample = self.plant.sample(field=self._steps % FIELD_STEPS == 0)
        self._fusion.feel(sample, self.plant.now)
        if self._steps % FIELD_STEPS == 0:
            self._happens(MotorsSeen(motors=ARMED, arrived=self.plant.now))
            self._happens(RangesSeen(ranges=FREE, arrived=self.plant.now))
        if self._steps % TICK_STEPS == 0:
            if self._steps % self._state_steps == 0:
                self._happens(AttitudeSeen(attitude=self._fusion.state(self.plant.now), arrived=self.plant.now))
            self._happens(Tick())
            self._under_way.append((self._drive.left, self._drive.right))
            while len(self._under_way) > self._dice.choice(WAY_TICKS) + 1:
                self._under_way.popleft()

    def _say(self, command: TurnCommand | HeadingCommand, name: str) -> None:
        now = self.plant.now
        event = Command(command=command, source="bench", new_lease=f"L{name}", new_goal=name, received=now)
        self._happens(event)

    def _happens(self, event: Event) -> None:
        self._drive, said = decide(self._drive, event, self.plant.now)
        self.results += [output.message for output in said if isinstance(output, Result)]


def _calibrated(imu: Imu) -> dict[str, float]:
    """Return the rows of a compass that was calibrated as well as can be."""
    inverse = np.linalg.inv(np.array(imu.soft_iron))
    values = dict(zip(OFFSETS, imu.hard_iron_ut, strict=True))
    for names, row in zip(MATRIX, inverse.tolist(), strict=True):
        values |= dict(zip(names, row, strict=True))
    return values
