"""The manoeuvres, their holders and their ends, as a pure function of state, event and time."""

from math import inf

from msgspec import Struct
from msgspec.structs import replace

from lbr.leases import decide as leasing
from lbr.leases import ending, rules
from lbr.leases.ask import resolve
from lbr.leases.lease import (
    Ending,
    EstopChanged,
    Happened,
    Lease,
    LeaseRequest,
    LeaseTable,
    Phrasing,
    Reply,
    Result,
    Stop,
    first,
)
from lbr.messages.beacon import Manoeuvre
from lbr.messages.codes import Reason
from lbr.operations.results import goal_result

PHRASING = Phrasing(
    noun="the search for the dock", rest="stop, or pause, before going on", idle="nothing was looked for yet"
)


class Seeking(Struct, frozen=True, kw_only=True):
    """A manoeuvre in progress."""

    goal: str
    manoeuvre: Manoeuvre
    started: float


class Seek(Struct, frozen=True, kw_only=True):
    """A sender's request for a manoeuvre, or its renewal. `trouble` is the reason why the drive would not follow, or
    None."""

    ask: LeaseRequest
    manoeuvre: Manoeuvre
    new_goal: str
    trouble: Reason | None = None


class Over(Struct, frozen=True, kw_only=True):
    """A manoeuvre is over by itself, or cannot continue."""

    goal: str
    how: Ending
    why: Reason


class Tick(Struct, frozen=True, kw_only=True):
    """The time of a round."""


class Begin(Struct, frozen=True, kw_only=True):
    """The start of a manoeuvre."""

    seeking: Seeking


class Halt(Struct, frozen=True, kw_only=True):
    """A stop of the robot; `lost`: the manoeuvre's sender is gone; `by`: the sender of the stop."""

    why: str
    lost: bool = False
    by: str = ""


Event = Seek | Over | Stop | EstopChanged | Tick
Output = Reply | Begin | Halt | Result | Happened
Outputs = tuple[Output, ...]


class State(Struct, frozen=True, kw_only=True):
    """The whole state of the kernel; `clock` is the time of the last event, `why` the end of the last manoeuvre."""

    leases: LeaseTable[Seeking]
    clock: float = -inf
    why: Reason | None = None

    @property
    def lease(self) -> Lease[Seeking] | None:
        """Return the holder and its manoeuvre."""
        return self.leases.live


def first_state(ttl_s: float, began: float = -inf) -> State:
    """Return the state with nothing requested since it `began`."""
    return State(leases=first(PHRASING, ttl_s, began=began))


def decide(state: State, event: Event, now: float) -> tuple[State, Outputs]:
    """Return the state after an event, and the outputs; what is over by `now` ends before the event counts."""
    if now >= state.clock:
        held, ends = ending.lapse(state.leases, now)
    else:
        held, ends = ending.lose_time(state.leases, state.clock, now)
    state, outputs = _ended(replace(state, leases=held, clock=now), ends, now)
    state, more = _handle(state, event, now)
    return state, outputs + more


def _handle(state: State, event: Event, now: float) -> tuple[State, Outputs]:
    match event:
        case Seek():
            return _seek(state, event, now)
        case Stop():
            held, ends = leasing.stop(state.leases, event, now)
            state, outputs = _ended(replace(state, leases=held), ends, now, by=event.by or event.source)
            return state, (*outputs, leasing.STOPPED)
        case EstopChanged():
            held, ends = leasing.latch(state.leases, event, now)
            return _ended(replace(state, leases=held), ends, now)
        case Over(goal=goal, how=how, why=why):
            if state.lease is None or state.lease.motion.goal != goal:
                return state, ()
            held, ends = ending.end(state.leases, how, why, now)
            return _ended(replace(state, leases=held), ends, now)
    return state, ()


def _seek(state: State, event: Seek, now: float) -> tuple[State, Outputs]:
    ask = resolve(state.leases, event.ask, now)
    if why := rules.refusal(ask, event.trouble):
        held, refused = leasing.refuse(ask, why)
        return replace(state, leases=held), (refused,)
    if ask.wants == "renewal":
        held = leasing.renew(ask)
        lease = leasing.lent(held, ask)
        return replace(state, leases=held), (leasing.accepted(lease, goal=lease.motion.goal),)
    goal = ask.confirms.motion.goal if ask.confirms is not None else event.new_goal
    seeking = Seeking(goal=goal, manoeuvre=event.manoeuvre, started=now)
    held, ends = leasing.grant(state.leases, ask, seeking)
    state, outputs = _ended(replace(state, leases=held), ends, now)
    begin: Outputs = () if ask.wants == "offer" else (Begin(seeking=seeking),)
    return state, (*outputs, *begin, leasing.accepted(leasing.lent(held, ask), goal=goal))


def _ended(state: State, ends: ending.Endings[Seeking], now: float, *, by: str = "") -> tuple[State, Outputs]:
    """Return the state and outputs after the end of leases."""
    outputs: Outputs = ()
    for ended in ends:
        if isinstance(ended, Happened):
            outputs += (ended,)
            continue
        if ended.held:
            state = replace(state, why=ended.why)
            outputs += (Halt(why=ended.why.text, lost=ended.how == "lapsed", by=by),)
        seeking = ended.lease.motion
        outputs += (goal_result(ended, seeking.goal, seeking.started, now),)
    return state, outputs
