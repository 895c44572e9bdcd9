"""Docking in the simulated world, in lockstep: from the start, and from wherever the robot is let go in the room.

Physics, beams and battery are the world's; the drive is left out: powers go straight to the wheels, and turns are made by the true angle. After the
first trial the compass is wrong by up to 18 degrees.
"""

from math import copysign, degrees, pi, radians, remainder, tau
from random import Random

from lbr.apps.autodock.script import Manner, dock
from lbr.apps.autodock.view import Action, Back, Ending, Go, Turn, View
from lbr.messages.motors import MotorsState
from lbr.messages.simulation import WorldPose
from lbr.operations.battery import BatterySettings
from lbr.operations.battery.gauge import Gauge
from lbr.operations.drive.mixing import mix
from lbr.operations.drive.settings import DriveSettings
from lbr.simulation.engine import Engine
from lbr.simulation.settings import StartPose, WorldSettings

STEP_S, LATE_STEPS = 0.02, 8
PROMISED_S, LONGEST_S = 120.0, 400.0
TURN_SPEED = 0.15
STUCK_S, STANDS_MPS, STANDS_RPS = 1.0, 0.02, 0.05
"""As the drive ends what it cannot move."""
COMPASS_DEG = 18.0
ROOM_X_M, ROOM_Y_M = (-1.5, 4.5), (-2.5, 2.5)
TURN_STEPS = 450
"""More than a whole turn at TURN_SPEED."""
HARD = StartPose(x_m=2.0, y_m=-1.5, yaw_rad=radians(160.0))
"""Beside the crate, with the dock behind it."""


class Trial:
    """A robot in the world that does as docking says, a bit late."""

    def __init__(self, start: StartPose, seed: int, compass_error_deg: float = 0.0) -> None:
        self.engine = Engine(WorldSettings(start=start, seed=seed))
        self.now = 0.0
        self._error_deg = compass_error_deg
        self._gauge = Gauge(BatterySettings())
        self._power = (0.0, 0.0)
        self._action: Action | None = None
        self._target = 0.0
        self._travelled = self._stuck_s = 0.0
        self._ending: Ending | None = None
        self._seen: dict[str, float] = {}
        self._turned = degrees(self.engine.pose().yaw_rad)

    def run(self, manner: Manner) -> Ending:
        """Dock, and return how that ended."""
        script = dock(manner)
        action, views = next(script), []
        while self.now < LONGEST_S:
            self._step(action)
            views.append(self._view())
            if len(views) % 5 == 0 and len(views) > LATE_STEPS:
                try:
                    action = script.send(views[-LATE_STEPS] if self._action is action else views[-1])
                except StopIteration as end:
                    return end.value
        return Ending(good=False, text=f"not within {LONGEST_S:.0f} s")

    def _step(self, action: Action) -> None:
        if action is not self._action and not (isinstance(action, Back) and isinstance(self._action, Back)):
            self._ending, self._travelled = None, 0.0
            self._target = self._turned - (action.angle_deg if isinstance(action, Turn) else 0.0)
        self._action = action
        self.engine.step(*self._powers(action), STEP_S)
        self.now += STEP_S
        pose = self.engine.pose()
        self._travelled += pose.speed_mps * STEP_S
        self._stuck_s = self._stuck_s + STEP_S if pose.touching and self._stands(pose) else 0.0
        if self._stuck_s > STUCK_S and isinstance(action, Go | Turn) and self._ending is None:
            self._ending = Ending(good=False, text="the wheels stand although the motors push")
        self._turned += degrees(remainder(pose.yaw_rad - radians(self._turned), tau))

    @staticmethod
    def _stands(pose: WorldPose) -> bool:
        return abs(pose.speed_mps) < STANDS_MPS and abs(pose.turn_rps) < STANDS_RPS

    def _powers(self, action: Action) -> tuple[float, float]:
        if self._ending is not None:
            return (0.0, 0.0)
        if isinstance(action, Turn):
            left = self._target - self._turned
            if abs(left) < 1.0:
                self._ending = Ending(good=True, text="turned")
                return (0.0, 0.0)
            power = copysign(min(TURN_SPEED, 0.02 + abs(left) * 0.004), left)
            return (-power, power)
        if isinstance(action, Go):
            ahead = action.distance_m >= 0.0
            range_m = self.engine.ranges_m["forward" if ahead else "back"]
            if abs(self._travelled) >= abs(action.distance_m) - 0.02:
                self._ending = Ending(good=True, text="drove")
                return (0.0, 0.0)
            if range_m is not None and range_m < 0.3:
                self._ending = Ending(good=False, text="an obstacle is in the way")
                return (0.0, 0.0)
            return mix(action.power, 0.0 if ahead else 180.0, DriveSettings())
        if isinstance(action, Back):
            return mix(action.power, 180.0 - action.steer_deg, DriveSettings())
        return (0.0, 0.0)

    def _view(self) -> View:
        sensed = self.engine.sensed()
        for beam in sensed.beams:
            self._seen[beam] = self.now
        self._gauge.see(
            MotorsState(
                left=self.engine.pose().left,
                right=self.engine.pose().right,
                armed=True,
                reason="",
                estop=False,
                voltage_v=round(sensed.battery_v, 1),
                counts_left=sensed.counts[0],
                counts_right=sensed.counts[1],
            ),
            self.now,
        )
        battery = self._gauge.state(self.now)
        return View(
            time_s=self.now,
            direction_deg=-self._turned + self._error_deg,
            forward_m=sensed.ranges_m["forward"],
            back_m=sensed.ranges_m["back"],
            beams=frozenset(beam for beam, at in self._seen.items() if self.now - at < 0.3),  # type: ignore[misc]
            charging=battery.charging,
            rest_voltage_v=battery.rest_voltage_v,
            ending=self._ending,
        )


def starts(count: int, seed: int) -> list[StartPose]:
    """Where the robot begins: the world's own start, then anywhere in the room where it can turn."""
    random = Random(seed)
    poses = [StartPose(), HARD]
    while len(poses) < count:
        x, y = random.uniform(*ROOM_X_M), random.uniform(*ROOM_Y_M)
        pose = StartPose(x_m=x, y_m=y, yaw_rad=random.uniform(-pi, pi))
        if free(pose):
            poses.append(pose)
    return poses[:count]


def free(start: StartPose) -> bool:
    """Say whether the robot can stand there, and turn there without touching anything."""
    engine = Engine(WorldSettings(start=start))
    for _ in range(TURN_STEPS):
        engine.step(-TURN_SPEED, TURN_SPEED, STEP_S)
        if engine.touching():
            return False
    return True
