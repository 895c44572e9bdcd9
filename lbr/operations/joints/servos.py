"""The servo driver's reports: torque from before this process, and servos that released by themselves."""

from math import nan

from msgspec.structs import replace

from lbr.leases.lease import Happened
from lbr.messages.servos import ServoState
from lbr.operations.joints import moving, stored
from lbr.operations.joints.ending import Decision, end_what_is_over
from lbr.operations.joints.state import Outputs, ServosLost, ServosSeen, State, joint_trouble, waits, without

UNREAD_S = 3.0
"""After this time a driver that has not reported a servo's torque never will."""
SWITCHING_S = 1.0
"""The time that a servo may take to show the torque that was switched on."""


def seen(state: State, event: ServosSeen, now: float) -> Decision:
    """Process a sweep; an overtaken one, or one of a driver that is gone, changes nothing."""
    if event.arrived < state.servos_lost:
        return state, ()
    by_id = {servo.id: servo for servo in event.servos.servos}
    found = {name: by_id[joint.device_id] for name, joint in state.body.joints.items() if joint.device_id in by_id}
    arrived = min(event.arrived, now)  # this way round, NaN stays NaN
    driver_since = arrived if state.servos is None else state.driver_since
    state = expired(replace(state, servos=event.servos, seen=found, servos_at=arrived, driver_since=driver_since), now)
    state = replace(state, waited=now) if waits(state) else state
    state = stored.begun_playing(moving.followed(_note_released(_late_servos(_adopted(state, now), now), now)), now)
    state, released = _without_torque(state, now)
    state, ended = end_what_is_over(state, now)
    return _without_unmeasured(state, now), released + ended


def driver_lost(state: State, event: ServosLost, now: float) -> Decision:
    """End the current motion; the servos' state is unknown."""
    state = replace(state, servos=None, servos_gone=event.reason, servos_lost=now, servos_at=nan)
    state, ended = end_what_is_over(state, now)
    return expired(replace(state, seen={}), now), ended


def expired(state: State, now: float) -> State:
    """Return the state without knowledge that has expired: no setpoints are sent until the servos report again."""
    return state if _known(state, now) else replace(state, adopted=False)


def _known(state: State, now: float) -> bool:
    """Return whether the driver obeys, or the servos are known to be without torque."""
    servos = state.servos
    if servos is None or not state.seen or not now - state.servos_at <= state.settings.servos_max_age_s:
        return False
    return servos.phase == "released" or servos.armed or servos.estop or state.lost


def _adopted(state: State, now: float) -> State:
    """Adopt servos in their present state: those with torque are held where they were measured.

    The mover from before this process is lost; a driver that was away meanwhile lost none. A driver that has just
    started needs a moment to read the torque of its servos.
    """
    if state.adopted or not _known(state, now):
        return state
    tells = state.servos is not None and state.servos.tells_torque
    unread = tells and any(servo.torque is None and not servo.reason for servo in state.seen.values())
    if unread and now - state.driver_since < UNREAD_S:
        return state
    on = frozenset(name for name, servo in state.seen.items() if _has_torque(state, name, servo))
    goals = {name: moving.as_found(state, name) for name in on}
    strength = {name: share for name in on if (share := state.seen[name].torque) is not None and share < 1.0}
    lost = bool(on) and (state.lost or not state.begun)
    halt = state.halt + 1
    silent = frozenset(name for name, servo in state.seen.items() if servo.torque is None) - on
    state = replace(state, adopted=True, begun=True, on=on, goals=goals, lost=lost, halt=halt, switched=now)
    releasing = state.servos is not None and state.servos.phase == "releasing"
    return replace(state, unread=silent, strength={} if releasing else strength)


def _late_servos(state: State, now: float) -> State:
    """Hold a servo that was silent until now and has torque, too: it had a holder before this process began."""
    torque = {name: state.seen[name].torque for name in state.unread & state.seen.keys()}
    reporting = frozenset(name for name, found in torque.items() if found is not None)
    on = frozenset(name for name in reporting if torque[name])
    state = replace(state, unread=state.unread - reporting)
    return replace(state, on=state.on | on, switched=now) if on else state


def _has_torque(state: State, name: str, servo: ServoState) -> bool:
    """Return whether a servo has torque, by the last knowledge if it does not answer."""
    return name in state.on if servo.torque is None else servo.torque > 0.0


def _note_released(state: State, now: float) -> State:
    """Mark servos as released if the driver has released them in a phase in which it decides."""
    servos = state.servos
    decides = servos is not None and (state.lost or servos.estop or not servos.armed)
    if servos is None or not (state.adopted and decides and servos.phase == "released"):
        return state
    return _off(state, state.on, now) if state.on else state


def _off(state: State, names: frozenset[str], now: float) -> State:
    return replace(without(state, names), resting=names, released_at=now)


def _without_torque(state: State, now: float) -> Decision:
    """Mark a servo that released by itself as without torque, until that is switched on again, even after its fault."""
    if state.move is not None and state.move.stored is not None:
        return state, ()  # its controller has them
    late = now - max(state.switched, state.waited) >= SWITCHING_S
    reasons = {}
    for name in state.on & state.seen.keys():
        servo = state.seen[name]
        if servo.latched or (late and servo.torque == 0.0):
            reasons[name] = f"it has latched {', '.join(servo.latched)}" if servo.latched else servo.reason
    if not reasons:
        return state, ()
    events: Outputs = tuple(
        Happened(
            kind="let_go",
            text=f"{name} is without torque: {why or 'its servo released'}",
            level="warning",
            code="latched" if state.seen[name].latched else "no_torque",
        )
        for name, why in reasons.items()
    )
    return _off(state, frozenset(reasons), now), events


def _without_unmeasured(state: State, now: float) -> State:
    """Hold a servo that is not measured at its position, and after its return at its position then."""
    if state.move is not None and state.move.stored is not None:
        return state
    changed: dict[str, float | None] = {}
    for name in state.on:
        trouble, goal = joint_trouble(state, name, now), state.goals.get(name)
        if trouble and goal is not None:
            changed[name] = None
        elif not trouble and goal is None:
            changed[name] = moving.measured(state, name)
    return replace(state, goals={**state.goals, **changed})
