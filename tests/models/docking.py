"""Docking by its table in the simulated world, in lockstep: from the start, from wherever the robot is put in the room, and with faults.

Physics, beams and battery are the world's, the table's run and the beacon's manoeuvres are the robot's own; the drive is left
out: powers go straight to the wheels, and turns are made by the true angle.
"""

from math import copysign, degrees, inf, pi, radians, remainder, tau
from random import Random

from msgspec import Struct
from msgspec.structs import replace

from lbr.apps.behaviours.cells import Value
from lbr.apps.behaviours.keys import Key
from lbr.apps.behaviours.table import Table
from lbr.messages.battery import BatteryState
from lbr.messages.beacon import BeaconState
from lbr.messages.dock import DockSignal
from lbr.messages.motors import MotorsState
from lbr.messages.simulation import WorldPose
from lbr.operations.battery import BatterySettings
from lbr.operations.battery.gauge import Gauge
from lbr.operations.beacon import BeaconSettings
from lbr.operations.beacon.capability import PATIENCE_S
from lbr.operations.beacon.view import STAND, Action, Back, Ending, Go, Turn, View
from lbr.operations.drive.mixing import mix
from lbr.operations.drive.settings import DriveSettings
from lbr.simulation.engine import Engine
from lbr.simulation.settings import BoxSettings, Dock, StartPose, Ultrasonic, WorldSettings
from tests.models.table_run import TableRun

STEP_S, LATE_STEPS, ROUND_STEPS = 0.02, 8, 5
PROMISED_S = 120.0
TURN_SPEED = 0.15
STUCK_S, STANDS_MPS, STANDS_RPS = 1.0, 0.02, 0.05
"""As the drive ends what it cannot move."""
COMPASS_DEG = 20.0
NOISY = Ultrasonic(noise_m=0.01, noise_per_m=0.01, dropout=0.01)
ROOM_X_M, ROOM_Y_M = (-1.5, 4.5), (-2.5, 2.5)
TURN_STEPS = 450
"""More than a whole turn at TURN_SPEED."""
HARD = StartPose(x_m=2.0, y_m=-1.5, yaw_rad=radians(160.0))
"""Beside the crate, with the dock behind it."""
WALKING_MPS = 1.4
LAST_S = 2.0
"""After the end it is looked on for so long: then the robot stands."""


class Faults(Struct, frozen=True, kw_only=True):
    """What is wrong with a trial; times are from its start.

    `deaf` are the beams that are not seen from `deaf_s` on. From `blind_s` on the ranges measure nothing. With `slip` the wheels
    turn up to so much farther than the robot goes.
    """

    dock: Dock | None = Dock()
    box: BoxSettings | None = None
    deaf: frozenset[str] = frozenset()
    deaf_s: float = 0.0
    blind_s: float = inf
    slip: float = 0.0


BOX = BoxSettings(name="box", x_m=-0.5, y_m=1.2, length_m=0.4, width_m=0.5)
FAULTS: dict[str, Faults] = {
    "dock gone": Faults(dock=None),
    "dock without power": Faults(deaf=frozenset({"left", "right", "power"}), dock=replace(Dock(), current_a=0.0)),
    "beams end on the way": Faults(deaf=frozenset({"left", "right"}), deaf_s=25.0),
    "dock blocked": Faults(box=BOX),
    "dock moved along its wall": Faults(dock=replace(Dock(), y_m=-0.4)),
    "dock moved to another wall": Faults(dock=replace(Dock(), x_m=1.5, y_m=-2.14, yaw_rad=pi / 2)),
    "left beam dead": Faults(deaf=frozenset({"left"})),
    "right beam dead": Faults(deaf=frozenset({"right"})),
    "ranges dead on the way": Faults(blind_s=20.0),
    "battery does not charge": Faults(dock=replace(Dock(), current_a=0.0)),
    "wheels slip": Faults(slip=0.3),
}


class Trial:
    """A robot in the world that does as the table says, a bit late.

    `fastest_mps` is how fast it came against anything, the dock too; `state` is where the table ended.
    """

    def __init__(
        self,
        start: StartPose,
        seed: int,
        compass_error_deg: float = 0.0,
        faults: Faults | None = None,
        ultrasonic: Ultrasonic = NOISY,
    ) -> None:
        self.faults = faults or Faults()
        world = WorldSettings(start=start, seed=seed, dock=self.faults.dock, ultrasonic=ultrasonic)
        if self.faults.box is not None:
            world = replace(world, walls=(*world.walls, self.faults.box))
        self.engine = Engine(world)
        self.now = 0.0
        self.fastest_mps = 0.0
        self.state = ""
        self._random = Random(seed)
        self._error_deg = compass_error_deg
        self._gauge = Gauge(BatterySettings())
        self._action: Action = STAND
        self._goes_on = False
        self._target = 0.0
        self._travelled = self._stuck_s = 0.0
        self._slipped = (1.0, 1.0)
        self._ending: Ending | None = None
        self._seen: dict[str, float] = {}
        self._turned = degrees(self.engine.pose().yaw_rad)
        self._against = False
        self._views: list[View] = []
        self._follows = 0
        self._looked_s = 0.0
        self._before_v: float | None = None

    def run(self, table: Table) -> Ending:
        """Run the table to its end, and return how that was; the robot is looked on for a while afterwards."""
        running = TableRun(table, self.now, self._random.randrange, BeaconSettings())
        while (ending := running.ending) is None:
            self._step()
            if len(self._views) % ROUND_STEPS == 0:
                self._round(running)
        self.state, took_s = running.run.state, self.now
        self._do(STAND)
        while self.now < took_s + LAST_S:
            self._step()
        self.now = took_s
        return ending

    def _round(self, running: TableRun) -> None:
        """Decide by what is seen now, or was a bit before while an action goes on."""
        if running.follows != self._follows:
            self._follows, self._before_v = running.follows, self._gauge.state(self.now).rest_voltage_v
        if self.now < self.faults.blind_s:
            self._looked_s = self.now
            late = len(self._views) > LATE_STEPS and self._goes_on
            self._do(running.round(self._views[-LATE_STEPS if late else -1], self.now, self._look))
        elif self.now - self._looked_s > PATIENCE_S:
            blind = Ending(good=False, text="the sensors measure nothing", code="stale_sensor")
            self._do(running.round(self._views[-1], self.now, self._look, failed=blind))
        else:
            self._do(STAND)

    def _do(self, action: Action) -> None:
        self._goes_on = action is self._action
        if not self._goes_on and not (isinstance(action, Back) and isinstance(self._action, Back)):
            self._ending, self._travelled = None, 0.0
            self._target = self._turned - (action.angle_deg if isinstance(action, Turn) else 0.0)
            most = 1.0 - self.faults.slip
            self._slipped = (self._random.uniform(most, 1.0), self._random.uniform(most, 1.0))
        self._action = action

    def _step(self) -> None:
        powers = self._powers(self._action)
        before = self.engine.pose().speed_mps
        self.engine.step(*(power * share for power, share in zip(powers, self._slipped, strict=True)), STEP_S)
        self.now += STEP_S
        pose = self.engine.pose()
        against = pose.touching or pose.charging
        if against and not self._against:
            self.fastest_mps = max(self.fastest_mps, abs(before))
        self._against = against
        self._travelled += pose.speed_mps * STEP_S * 2 / sum(self._slipped)
        self._stuck_s = self._stuck_s + STEP_S if pose.touching and self._stands(pose) else 0.0
        if self._stuck_s > STUCK_S and isinstance(self._action, Go | Turn) and self._ending is None:
            self._ending = Ending(good=False, text="the wheels stand although the motors push", code="stuck")
        self._turned += degrees(remainder(pose.yaw_rad - radians(self._turned), tau))
        self._views.append(self._view())

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
                self._ending = Ending(good=False, text="an obstacle is in the way", code="obstacle")
                return (0.0, 0.0)
            return mix(action.power, 0.0 if ahead else 180.0, DriveSettings())
        if isinstance(action, Back):
            return mix(action.power, 180.0 - action.steer_deg, DriveSettings())
        return (0.0, 0.0)

    def _view(self) -> View:
        sensed = self.engine.sensed()
        for beam in sensed.beams:
            if beam not in self.faults.deaf or self.now < self.faults.deaf_s:
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
        return View(
            time_s=self.now,
            direction_deg=-self._turned + self._error_deg,
            forward_m=sensed.ranges_m["forward"],
            back_m=sensed.ranges_m["back"],
            beams=frozenset(beam for beam, at in self._seen.items() if self.now - at < 0.3),  # type: ignore[misc]
            charging=self._gauge.state(self.now).charging,
            ending=self._ending,
        )

    def _look(self, key: Key, newest_s: float) -> Value | None:
        """Return what a column of the table asks for."""
        del newest_s
        battery: BatteryState = self._gauge.state(self.now)
        volts, before = battery.rest_voltage_v, self._before_v
        seen = {beam: self.now - self._seen.get(beam, -inf) < 1.0 for beam in ("left", "right", "power")}
        messages = {
            "battery": battery if battery.valid else None,
            "dock": DockSignal(**seen),
            "beacon": BeaconState(risen_v=None if volts is None or before is None else round(volts - before, 2)),
        }
        return key.read(messages[key.stream])


def safe(trial: Trial, ending: Ending) -> list[str]:
    """Return what is not safe about how a trial ended."""
    pose = trial.engine.pose()
    wrong = [] if abs(pose.speed_mps) < STANDS_MPS and abs(pose.turn_rps) < STANDS_RPS else ["it moves on"]
    if ending.good and not pose.charging:
        wrong.append("it says that it docked, and is not charged")
    if trial.fastest_mps > WALKING_MPS:
        wrong.append(f"it came against something at {trial.fastest_mps:.1f} m/s")
    return wrong


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
