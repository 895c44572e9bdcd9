"""State, events and outputs of the joints kernel."""

from collections.abc import Mapping
from math import inf, nan

from msgspec import Struct
from msgspec.structs import replace

from lbr.leases.lease import (
    EstopChanged,
    Happened,
    LeaseTable,
    Origin,
    Phrasing,
    Reply,
    Result,
    Setpoint,
    Stop,
    first,
)
from lbr.messages.codes import Reason
from lbr.messages.joints import JointsCommand, TorqueCommand
from lbr.messages.servos import ServosState, ServoState
from lbr.operations.joints.body import Body
from lbr.operations.joints.move import Move, ToFeet
from lbr.operations.joints.settings import JointsSettings

LAPSE_AHEAD_ROUNDS = 1.5
"""The reserve for a lapse: the loop notices it up to a round late."""
REST_S = 0.1
PASSES_ON = ("", "pc")
"""The modes of the servos' controller in which goals reach the servos."""


class Command(Origin, frozen=True, kw_only=True):
    """A motion command, with fresh ids in case it is accepted."""

    command: JointsCommand
    new_goal: str


class Torque(Struct, frozen=True, kw_only=True):
    """A sender's request to switch the torque of joints."""

    command: TorqueCommand
    source: str
    received: float
    remote: bool = False
    answerable: bool = True


class HolderGone(Struct, frozen=True, kw_only=True):
    """The process that holds the joints is gone."""

    source: str


class ServosSeen(Struct, frozen=True, kw_only=True):
    """The servo driver published the state of every servo."""

    servos: ServosState
    arrived: float


class ServosLost(Struct, frozen=True, kw_only=True):
    """The servo driver is gone."""

    reason: str


class Tick(Struct, frozen=True, kw_only=True):
    """Time for the next setpoint."""


Event = Command | Torque | Stop | HolderGone | EstopChanged | ServosSeen | ServosLost | Tick


Output = Reply | Setpoint | Happened | Result
Outputs = tuple[Output, ...]


class State(Struct, frozen=True, kw_only=True):
    """The whole state of the kernel.

    `on` are the joints with torque, `goals` their commanded positions in their own radians (None: the present one).
    `strength` are the fractions of joints with less than full torque. They are known once the driver reported
    (`adopted`; `begun`: it once did); no setpoints are sent before that. Times: the driver is present since
    `driver_since`, torque was last switched on at `switched`. Joints released at `released_at` are `resting`: setpoints
    must show them without torque before it returns. The torque of `unread` joints is unknown yet. `lost`: the mover is
    gone, and the driver decides. `halt` counts the holds of all joints where they were measured, `count` the orders to
    the controller. Until `waited` it passed no goals on. `feet`: the robot was stopped on its way, and steps to its
    feet.
    """

    settings: JointsSettings
    body: Body
    leases: LeaseTable[Move]
    clock: float = -inf
    adopted: bool = False
    begun: bool = False
    on: frozenset[str] = frozenset()
    goals: Mapping[str, float | None] = {}
    strength: Mapping[str, float] = {}
    lost: bool = False
    halt: int = 0
    feet: ToFeet | None = None
    count: int = 0
    waited: float = -inf
    ticked: float = nan
    servos: ServosState | None = None
    seen: Mapping[str, ServoState] = {}
    servos_at: float = nan
    driver_since: float = nan
    switched: float = -inf
    released_at: float = -inf
    unread: frozenset[str] = frozenset()
    resting: frozenset[str] = frozenset()
    servos_lost: float = -inf
    servos_gone: str = "the servo driver has not reported yet"

    @property
    def move(self) -> Move | None:
        """The current motion."""
        return self.leases.live.motion if self.leases.live is not None else None


NOT_ADOPTED = Reason("not_ready", "the search for servos goes on; try again")
PHRASING = Phrasing(
    noun="the joints",
    rest="stop, or pause, before moving again",
    idle="no sender moves the joints",
)


def first_state(settings: JointsSettings, body: Body, began: float = -inf) -> State:
    """Return the state of joints that were not moved since it `began`."""
    ahead_s = LAPSE_AHEAD_ROUNDS / settings.rate_hz
    return State(settings=settings, body=body, leases=first(PHRASING, settings.ttl_s, ahead_s, began=began))


def without(state: State, names: frozenset[str]) -> State:
    """Return the state in which these joints have no torque."""
    goals = {name: goal for name, goal in state.goals.items() if name not in names}
    return replace(state, on=state.on - names, goals=goals)


def position_rad(state: State, name: str) -> float | None:
    """Return the measured position of a joint, in its own radians."""
    servo = state.seen.get(name)
    if servo is None or servo.position_rad is None:
        return None
    return state.body.joint_rad(name, servo.position_rad)


def age_s(state: State, name: str, now: float) -> float:
    """Return the age of a joint's measured position; infinite if unknown."""
    servo = state.seen.get(name)
    return inf if servo is None or servo.age_s is None else servo.age_s + max(0.0, now - state.servos_at)


def unmeasured(state: State, name: str, now: float) -> bool:
    """Return whether a joint has no recent measurement."""
    return position_rad(state, name) is None or not age_s(state, name, now) <= state.settings.joint_max_age_s


def waits(state: State) -> bool:
    """Return whether the servos' controller passes no goals on now; it resumes by itself."""
    return state.servos is not None and state.servos.mode not in PASSES_ON


def servos_trouble(state: State, now: float) -> Reason | None:
    """Return why no servo would follow, or None."""
    if state.servos is None:
        return Reason("unreachable", state.servos_gone)
    longest_s = state.settings.servos_max_age_s
    if not now - state.servos_at <= longest_s:
        return Reason("unreachable", f"the servo driver has been silent for more than {longest_s:g} s")
    if not (state.servos.armed or state.lost):
        return Reason("not_armed", f"the servos are not armed: {state.servos.reason or 'no reason given'}")
    return None


def joint_trouble(state: State, name: str, now: float) -> Reason | None:
    """Return why one joint would not follow, or None."""
    servo = state.seen.get(name)
    if servo is None:
        unknown = f"{name}: the servo driver does not know servo {state.body.joints[name].device_id}"
        return Reason("unreachable", unknown)
    if servo.latched:
        return Reason("latched", f"{name} has latched {', '.join(servo.latched)}: remove the cause, then recover it")
    if unmeasured(state, name, now) and not state.settings.open_loop:
        return Reason("stale_sensor", f"{name} is not measured: {servo.reason or _silent(servo)}")
    return None


def _silent(servo: ServoState) -> str:
    how = "reports what is not believed" if servo.trusted is False else "does not answer"
    return f"servo {servo.id} {how}"
