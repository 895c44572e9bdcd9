"""What the servos' driver says, taken in: what has torque when nobody here knew, and what let go by itself."""

from math import nan

from msgspec.structs import replace

from lbr.operations.joints import moving
from lbr.operations.joints.ending import Decision, end_what_is_over
from lbr.operations.joints.state import Outputs, ServosLost, ServosSeen, State, joint_trouble
from lbr.operations.leasing.state import Happened


def seen(state: State, event: ServosSeen, now: float) -> Decision:
    """Take in a sweep; what was overtaken, or came from a driver that is gone, changes nothing."""
    if event.arrived < state.servos_lost:
        return state, ()
    by_id = {servo.id: servo for servo in event.servos.servos}
    found = {name: by_id[joint.device_id] for name, joint in state.body.joints.items() if joint.device_id in by_id}
    arrived = min(event.arrived, now)  # this way round, NaN stays NaN
    state = replace(state, servos=event.servos, seen=found, servos_at=arrived)
    state, ended = end_what_is_over(_followed(_adopted(state, now)), now)
    state, told = _without_latched(state)
    return _without_unmeasured(state, now), ended + told


def gone(state: State, event: ServosLost, now: float) -> Decision:
    """End what was under way; what the servos do is not known any more."""
    state = replace(state, servos=None, servos_gone=event.reason, servos_lost=now, servos_at=nan)
    state, ended = end_what_is_over(state, now)
    return unlearnt(replace(state, seen={}), now), ended


def unlearnt(state: State, now: float) -> State:
    """Return the state without what is not known any more: then nothing is said until the servos are heard again."""
    return state if _known(state, now) else replace(state, adopted=False)


def _known(state: State, now: float) -> bool:
    """Say whether the driver does as it is told, or the servos are known to be without torque."""
    servos = state.servos
    if servos is None or not now - state.servos_at <= state.settings.servos_max_age_s:
        return False
    return servos.phase == "released" or servos.armed or servos.estop or state.lost


def _adopted(state: State, now: float) -> State:
    """Take over servos as they are, when it was not known: those with torque are held where they were measured.

    Whoever moved them before this process began is lost; a driver that was away meanwhile lost nobody.
    """
    if state.adopted or not _known(state, now):
        return state
    assert state.servos is not None
    released = state.servos.phase == "released"
    on = frozenset(() if released else (name for name, servo in state.seen.items() if servo.torque != 0.0))
    goals = {name: moving.measured(state, name) for name in on}
    lost = bool(on) and (state.lost or not state.begun)
    return replace(state, adopted=True, begun=True, on=on, goals=goals, lost=lost)


def _followed(state: State) -> State:
    """Take in that the driver has let go, where that is for the driver to decide."""
    servos = state.servos
    decides = servos is not None and (state.lost or servos.estop or not servos.armed)
    if servos is None or not (decides and servos.phase == "released"):
        return state
    return replace(state, on=frozenset(), goals={})


def _without_latched(state: State) -> Decision:
    """A servo that has latched a fault is without torque, also after it was recovered, until that is switched on."""
    latched = {name: state.seen[name].latched for name in state.on if name in state.seen and state.seen[name].latched}
    if not latched:
        return state, ()
    told: Outputs = tuple(
        Happened(kind="latched", text=f"{name} has latched {', '.join(faults)} and is without torque", level="warning")
        for name, faults in latched.items()
    )
    goals = {name: goal for name, goal in state.goals.items() if name not in latched}
    return replace(state, on=state.on - latched.keys(), goals=goals), told


def _without_unmeasured(state: State, now: float) -> State:
    """A servo that is not measured is to stay where it is, and when it comes back to hold where it is then."""
    changed: dict[str, float | None] = {}
    for name in state.on:
        trouble, goal = joint_trouble(state, name, now), state.goals.get(name)
        if trouble and goal is not None:
            changed[name] = None
        elif not trouble and goal is None:
            changed[name] = moving.measured(state, name)
    return replace(state, goals={**state.goals, **changed}) if changed else state
