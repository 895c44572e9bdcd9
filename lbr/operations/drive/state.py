"""State, events and outputs of the drive kernel."""

from collections.abc import Mapping
from math import inf, nan

from msgspec import Struct

from lbr.leases.lease import EstopChanged, Happened, Lease, LeaseTable, Origin, Reply, Result, Setpoint, Stop
from lbr.messages.attitude import AttitudeState
from lbr.messages.codes import Reason, heard
from lbr.messages.drive import CheckVerdict
from lbr.messages.kinematics import Base
from lbr.messages.motors import RESTS_S, MotorsState
from lbr.messages.odometry import OdometryState
from lbr.messages.sensing import Ranges, Scan
from lbr.operations.drive import heading_view, odometry_view
from lbr.operations.drive.command import Motion, Sides
from lbr.operations.drive.distance_goal import DistanceGoal
from lbr.operations.drive.heading_view import HeadingView
from lbr.operations.drive.obstacle_memory import ObstacleMemory
from lbr.operations.drive.odometry_view import OdometryView
from lbr.operations.drive.range_goal import RangeGoal
from lbr.operations.drive.rules import FREE, Limit, Odometer, View, unchanged
from lbr.operations.drive.sensors import Sensors
from lbr.operations.drive.settings import DriveSettings
from lbr.operations.drive.turn_goal import TurnGoal


class Command(Origin, frozen=True, kw_only=True):
    """A motion command, with fresh ids in case it is accepted. `checks`: the verdicts of the user's own checks."""

    command: Motion
    new_goal: str
    checks: Mapping[str, CheckVerdict | None] = {}


class MotorsSeen(Struct, frozen=True, kw_only=True):
    """The motor driver published its state."""

    motors: MotorsState
    arrived: float


class MotorsLost(Struct, frozen=True, kw_only=True):
    """The motor driver is gone."""

    reason: str


class RangesSeen(Struct, frozen=True, kw_only=True):
    """New distances arrived."""

    ranges: Ranges
    arrived: float


class ScanSeen(Struct, frozen=True, kw_only=True):
    """A new scan arrived."""

    scan: Scan
    arrived: float


class AttitudeSeen(Struct, frozen=True, kw_only=True):
    """The attitude arrived."""

    attitude: AttitudeState
    arrived: float


class OdometrySeen(Struct, frozen=True, kw_only=True):
    """The odometry arrived."""

    odometry: OdometryState
    arrived: float


class Tick(Struct, frozen=True, kw_only=True):
    """Time for the next setpoint."""


Event = (
    Command | Stop | EstopChanged | MotorsSeen | MotorsLost | RangesSeen | ScanSeen | AttitudeSeen | OdometrySeen | Tick
)


Output = Reply | Setpoint | Happened | Result
Outputs = tuple[Output, ...]


class Goal(Struct, frozen=True, kw_only=True):
    """The bounds of a move: until `sensor` has come to `target_m` (NaN: none), and no longer than until `ends`.

    `turn` is the target of a turn, `way` the length of a bounded move. `approach` is the approach to `target_m`, if its
    sensor looks along the way.
    """

    goal: str
    sensor: str
    target_m: float
    closing: bool
    started: float
    ends: float = inf
    last_m: float = nan
    last_seen: float = nan
    turn: TurnGoal | None = None
    way: DistanceGoal | None = None
    approach: RangeGoal | None = None


class ActiveMotion(Struct, frozen=True, kw_only=True):
    """The command in progress, and its bounds. It moves with `power` at most, towards `angle_deg`.

    A twist moves with the powers in `sides` at most.
    """

    command: Motion
    power: float
    angle_deg: float
    goal: Goal | None = None
    sides: Sides | None = None


class State(Struct, frozen=True, kw_only=True):
    """The whole state of the kernel. `clock` is the time of the last event.

    `left`, `right` and `aside`, to the left, are the current setpoint, which is not zero since `begun`.
    """

    settings: DriveSettings
    sensors: Sensors
    base: Base
    leases: LeaseTable[ActiveMotion]
    clock: float = -inf
    left: float = 0.0
    right: float = 0.0
    aside: float = 0.0
    ticked: float = nan
    begun: float = nan
    motors: MotorsState | None = None
    motors_at: float = nan
    motors_gone: str = "the motor driver has not reported yet"
    motors_lost: float = -inf
    views: Mapping[str, View] = {}
    scans: Mapping[str, Scan] = {}
    odometer: Odometer = Odometer()
    memory: ObstacleMemory = ObstacleMemory()
    heading: HeadingView = heading_view.UNKNOWN
    odometry: OdometryView = odometry_view.UNKNOWN
    limited: Limit = FREE
    blocked_since: float = nan
    reported_rule: str = ""
    reported_at: float = nan

    @property
    def sides(self) -> Sides:
        """The current setpoint."""
        return self.left, self.right, self.aside

    def ahead_mps(self, now: float) -> float:
        """Return the speed of the base, ahead or back: by the odometry, or by the setpoint if that is unknown."""
        if self.odometry.rests or odometry_view.not_known(self.odometry, now):
            return abs(self.left + self.right) / 2 * self.settings.max_speed_mps
        return abs(self.odometry.speed_mps)

    def seen(self, now: float) -> Mapping[str, View]:
        """Return the beliefs about the sensors; without a lease, distances that rest have not changed yet."""
        return unchanged(self.views, now) if self.lease is None else self.views

    @property
    def rests(self) -> bool:
        """Return whether the base stands still without a lease or offer, and its armed motors stand still, too."""
        motors = self.motors
        lent = self.lease is not None or bool(self.leases.offers)
        if motors is None or lent or any(self.sides):
            return False
        return motors.armed and not any((motors.left, motors.right, *(one.power for one in motors.motors.values())))

    @property
    def lease(self) -> Lease[ActiveMotion] | None:
        """Return the lease of the base, with its motion."""
        return self.leases.live


def motors_trouble(state: State, now: float) -> Reason | None:
    """Return why the motors would not follow, or None."""
    if state.motors is None:
        return Reason("unreachable", state.motors_gone)
    longest_s, at = state.settings.motors_max_age_s, state.motors_at
    if state.motors.rests and any(state.sides):
        at = max(at, state.begun)  # since then they have a setpoint, and this time to report that they move
    elif state.motors.rests:
        longest_s = max(longest_s, RESTS_S)
    if not now - at <= longest_s:
        return Reason("unreachable", f"the motor driver has been silent for more than {longest_s:g} s")
    if not state.motors.armed:
        why = f"the motors are not armed: {state.motors.reason or 'no reason given'}"
        return heard(state.motors.code or "not_armed", why)
    return None
