"""The end of a motion of the joints, by itself, by a stop or by a fault, and the messages about it."""

from msgspec.structs import replace

from lbr.leases import ending
from lbr.leases.lease import Ended, Happened, LeaseTable, Stop
from lbr.operations.joints import feet, moving, stored
from lbr.operations.joints.move import Move
from lbr.operations.joints.state import Outputs, State, servos_trouble
from lbr.operations.results import goal_result

Decision = tuple[State, Outputs]
Decided = tuple[LeaseTable[Move], ending.Endings[Move]]


def end_what_is_over(state: State, now: float) -> Decision:
    """End the motion if it is over at this time; with NaN in a comparison it is over."""
    held, trouble = state.leases, servos_trouble(state, now)
    decided = ending.drop_offers(held, held.offers, "fault", trouble) if trouble else ending.lapse(held, now)
    state, ended = take(state, decided, now)
    over = moving.ending(state, trouble, now)
    if over is None:
        return state, ended
    state, more = take(state, ending.end(state.leases, *over, now), now)
    return state, ended + more


def still(state: State, decided: Decided, now: float, stop: Stop | None = None) -> Decision:
    """Apply the decision on the holder of the joints, and hold all of them, whether they had a holder or not."""
    if state.move is not None:
        return take(state, decided, now, stop, at_once=stop is not None and stop.at_once)
    if stop is not None and not stop.at_once and (goes_on := feet.again(state, stop)) is not None:
        return take(goes_on, decided, now)
    state, outputs = take(moving.freeze(state), decided, now)
    return state, (*setpoint(state), *outputs)


def take(state: State, decided: Decided, now: float, stop: Stop | None = None, *, at_once: bool = False) -> Decision:
    """Apply a decision on the leases; without a holder hold the joints, and report how each motion ended.

    A motion ended by a `stop` or a lapse first steps to its feet, if it has a stable pose and need not hold `at_once`.
    """
    held, said = decided
    outputs: Outputs = ()
    for each in said:
        if isinstance(each, Happened):
            outputs = (*outputs, each)
            continue
        if each.held and held.live is None:
            state = _let_be(state, each, now, stop, at_once=at_once)
            outputs = (*outputs, *setpoint(state))
        if each.held and not _unremarkable(each):
            outputs = (*outputs, ending.happened(each))
        move = each.lease.motion
        outputs = (*outputs, goal_result(each, move.goal, move.begun, now))
    return replace(state, leases=held), outputs


def setpoint(state: State) -> Outputs:
    """Return the setpoint of the servos, if their state is known."""
    return (moving.setpoint(state),) if state.adopted else ()


def _unremarkable(ended: Ended[Move]) -> bool:
    """Return whether joined joints just arrived: reports of many small steps would be a flood."""
    move = ended.lease.motion
    return ended.how == "reached" and move.trajectory is None and move.stored is None and not ended.why.note


def _let_be(state: State, ended: Ended[Move], now: float, stop: Stop | None, *, at_once: bool) -> State:
    """Hold every joint: at its goal if that was reached, else where it was measured, or standing. After a lapse the
    mover counts as lost."""
    if ended.how in {"stopped", "lapsed"} and not at_once:
        lease, lapsed = ended.lease, ended.how == "lapsed"
        stepping = feet.begin(state, lease.motion, lease.id, stop, now, lost=lapsed)
        if stepping is not None:
            return replace(stepping, leases=replace(state.leases, live=None))
    lost, recording = state.lost or ended.how == "lapsed", ended.lease.motion.stored
    if ended.how == "reached":
        frozen = state if recording is None else stored.after(state, recording, now)
    else:
        frozen = moving.freeze(state)
    return replace(frozen, leases=replace(state.leases, live=None), lost=lost)
