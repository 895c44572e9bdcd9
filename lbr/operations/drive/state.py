"""What the drive kernel knows, what can happen to it, and what it says in return."""

from collections.abc import Mapping
from math import inf, nan
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from lbr.messages.attitude import AttitudeState
from lbr.messages.drive import CheckVerdict, GoalResult, Sensor
from lbr.messages.leases import CommandReply
from lbr.messages.motors import MotorSetpoint, MotorsState
from lbr.messages.odometry import OdometryState
from lbr.messages.sensing import Ranges
from lbr.messages.system import Role
from lbr.operations.drive import bearing, mileage
from lbr.operations.drive.asked import Motion
from lbr.operations.drive.bearing import Bearing
from lbr.operations.drive.memory import Memory
from lbr.operations.drive.mileage import Mileage
from lbr.operations.drive.rules import FREE, Limit, Odometer, View
from lbr.operations.drive.settings import DriveSettings
from lbr.operations.drive.travelling import Way
from lbr.operations.drive.turning import Turn

Ending = Literal["reached", "interval", "stopped", "lapsed", "superseded", "fault"]
Level = Literal["info", "warning", "error"]
DEAD_LEASES_KEPT = 32
TELLINGS = 20
"""Changes of holder told at once; more come back at `TELLINGS_PER_S`."""
TELLINGS_PER_S = 5.0
NOT_KNOWN = "it is not known here; ask for a new one without quoting a lease"


class Command(Struct, frozen=True, kw_only=True):
    """A motion command that was sent, or else came in, at `received`, with fresh ids in case it is accepted.

    `remote`: from another machine, whose clock said `sender_s` (NaN: it did not tell). `answerable`: somebody waits for
    the reply. `checks`: what the user's own checks said.
    """

    command: Motion
    source: str
    role: Role
    new_lease: str
    new_goal: str
    received: float
    remote: bool = False
    sender_s: float = nan
    answerable: bool = True
    checks: Mapping[str, CheckVerdict | None] = {}


class Stop(Struct, frozen=True, kw_only=True):
    """Somebody wants it to stand still."""

    source: str
    received: float
    reason: str = ""


class EstopChanged(Struct, frozen=True, kw_only=True):
    """The emergency stop was latched or reset."""

    engaged: bool
    reason: str = ""


class MotorsSeen(Struct, frozen=True, kw_only=True):
    """The motor driver said how it is."""

    motors: MotorsState
    arrived: float


class MotorsLost(Struct, frozen=True, kw_only=True):
    """The motor driver is gone."""

    reason: str


class RangesSeen(Struct, frozen=True, kw_only=True):
    """New distances came in."""

    ranges: Ranges
    arrived: float


class AttitudeSeen(Struct, frozen=True, kw_only=True):
    """The attitude came in."""

    attitude: AttitudeState
    arrived: float


class OdometrySeen(Struct, frozen=True, kw_only=True):
    """The odometry came in."""

    odometry: OdometryState
    arrived: float


class Tick(Struct, frozen=True, kw_only=True):
    """Time for the next setpoint."""


Event = Command | Stop | EstopChanged | MotorsSeen | MotorsLost | RangesSeen | AttitudeSeen | OdometrySeen | Tick


class Reply(Struct, frozen=True, kw_only=True):
    """The answer to the command or stop that was just decided."""

    message: CommandReply
    late: bool = False


class Setpoint(Struct, frozen=True, kw_only=True):
    """What the motors are to do now."""

    message: MotorSetpoint


class Happened(Struct, frozen=True, kw_only=True):
    """Something people should be told."""

    kind: str
    text: str
    level: Level = "info"
    data: Mapping[str, str] = {}


class Result(Struct, frozen=True, kw_only=True):
    """How a bounded move ended."""

    message: GoalResult


Output = Reply | Setpoint | Happened | Result
Outputs = tuple[Output, ...]


class Goal(Struct, frozen=True, kw_only=True):
    """The bounds of a move: until `sensor` has come to `target_m` (NaN: none), and no longer than until `ends`.

    `turn` is what a turn has to reach, `way` how far a bounded move goes.
    """

    goal: str
    sensor: Sensor
    target_m: float
    closing: bool
    started: float
    ends: float = inf
    last_m: float = nan
    last_seen: float = nan
    turn: Turn | None = None
    way: Way | None = None


class Hold(Struct, frozen=True, kw_only=True):
    """Who has the base: a live lease, the command it was given for, and the bounds of that command.

    The base moves with `power` at most, towards `angle_deg`.
    `said` is when that command was sent, `renewed` when the newest that quoted the lease was (NaN: none yet). `offset_s`
    is the least that a remote sender's clock was seen to be behind ours.
    """

    lease: str
    source: str
    command: Motion
    power: float
    angle_deg: float
    ttl_s: float
    expires: float
    changed: float
    said: float
    renewed: float = nan
    offset_s: float = inf
    goal: Goal | None = None


class Insisting(Struct, frozen=True, kw_only=True):
    """A source that goes on sending motion when it should not; `how` says so."""

    until: float
    how: str


class Tally(Struct, frozen=True, kw_only=True):
    """How many changes of holder may be told now, and how many were not."""

    left: float = TELLINGS
    at: float = -inf
    untold: int = 0


class State(Struct, frozen=True, kw_only=True):
    """Everything the kernel remembers. `left` and `right` are the setpoint now; `reason` says why it stands.

    `clock` is the time of the last event; `offers` are leases that remote senders have yet to quote; whatever was sent
    at or before `stopped` or `begun` begins nothing any more.
    """

    settings: DriveSettings
    clock: float = -inf
    hold: Hold | None = None
    offers: tuple[Hold, ...] = ()
    left: float = 0.0
    right: float = 0.0
    ticked: float = nan
    estop: bool = False
    estop_reason: str = ""
    motors: MotorsState | None = None
    motors_at: float = nan
    motors_gone: str = "the motor driver was not heard yet"
    motors_lost: float = -inf
    views: Mapping[Sensor, View] = {}
    odometer: Odometer = Odometer()
    memory: Memory = Memory()
    bearing: Bearing = bearing.UNHEARD
    mileage: Mileage = mileage.UNHEARD
    limited: Limit = FREE
    blocked_since: float = nan
    told: str = ""
    told_at: float = nan
    dead: tuple[tuple[str, str], ...] = ()
    stopped: float = -inf
    begun: float = -inf
    insisting: Mapping[str, Insisting] = {}
    tally: Tally = Tally()
    reason: str = "nobody drives"


def offered(state: State, lease: str) -> Hold | None:
    """Return the offer that a command quotes, if it still stands at the time of the last event."""
    return next((offer for offer in state.offers if offer.lease == lease), None)


def why_dead(state: State, lease: str) -> str:
    """Return why a lease that is not live died."""
    return dict(state.dead).get(lease, NOT_KNOWN)


def bury(state: State, lease: str, why: str) -> State:
    """Return the state with this lease dead for ever."""
    return replace(state, dead=(*state.dead, (lease, why))[-DEAD_LEASES_KEPT:])


def motors_trouble(state: State, now: float) -> str:
    """Return why the motors would not follow, or nothing."""
    if state.motors is None:
        return state.motors_gone
    longest_s = state.settings.motors_max_age_s
    if not now - state.motors_at <= longest_s:
        return f"the motor driver has been silent for more than {longest_s:g} s"
    if not state.motors.armed:
        return f"the motors are not armed: {state.motors.reason or 'no reason given'}"
    return ""
