"""Switching the torque of joints: on at their position, off only when that is confirmed."""

from collections.abc import Iterable, Mapping

from msgspec.structs import replace

from lbr.leases.lease import LATE_S, Happened, Reply
from lbr.leases.rules import STOP_CAME, latched, not_live
from lbr.messages.codes import Reason
from lbr.messages.leases import CommandReply, refused
from lbr.operations.joints import moving, stored
from lbr.operations.joints.ending import Decision, end_what_is_over, setpoint
from lbr.operations.joints.state import NOT_ADOPTED, State, Torque, joint_trouble, position_rad, servos_trouble, without

MOST_NAMED = 3


def switch(state: State, event: Torque, now: float) -> Decision:
    """Refuse to switch the torque, or switch it and report that."""
    if why := _refusal(state, event, now):
        return state, (Reply(message=refused(why)),)
    names = event.command.joints or tuple(state.body.joints)
    return _on(state, event, names, now) if event.command.on else _off(state, event, names, now)


def _on(state: State, event: Torque, names: tuple[str, ...], now: float) -> Decision:
    troubles = {name: why for name in names if (why := not_to_be_held(state, name, now))}
    fit = frozenset(names) - troubles.keys()
    sentences = "; ".join(why.text for why in list(troubles.values())[:MOST_NAMED])
    more = f" (and {len(troubles) - MOST_NAMED} more)" if len(troubles) > MOST_NAMED else ""
    if not fit:
        first = next(iter(troubles.values()))
        return state, (Reply(message=refused(Reason(first.code, sentences + more))),)
    state = moving.held_again(state)
    switched = fit - state.on
    strength = {name: share for name, share in state.strength.items() if name not in fit}
    state = replace(_held(state, fit, now), strength=strength)
    outputs = (
        *setpoint(state),
        *_switch_events(state, event.source, switched, on=True),
        _reply(sentences + more, *troubles.values()),
    )
    return state, outputs


def _off(state: State, event: Torque, names: tuple[str, ...], now: float) -> Decision:
    released = state.on & frozenset(names)
    state = replace(without(state, released), unread=state.unread - frozenset(names), lost=False)
    state, ended = end_what_is_over(state, now)
    return state, (*setpoint(state), *ended, *_switch_events(state, event.source, released, on=False), _reply())


def strengthen(state: State, source: str, strengths: Mapping[str, float], now: float) -> Decision:
    """Return the state in which joints have this torque from now on; joints without any get it at their position."""
    switched = frozenset(strengths) - state.on
    strengths = {**state.strength, **strengths}
    if not switched:
        return replace(state, strength=strengths), ()
    state = replace(_held(state, switched, now), strength=strengths)
    return state, _switch_events(state, source, switched, on=True)


def not_to_be_held(state: State, name: str, now: float) -> Reason | None:
    """Return why a joint cannot be held where it is, or None."""
    if why := joint_trouble(state, name, now):
        return why
    present_rad = position_rad(state, name)
    joint = state.body.joints[name]
    if present_rad is None or state.body.beyond_rad(name, present_rad) <= moving.MARGIN_RAD or name in state.on:
        return None
    limits = f"{joint.lower_rad:g} to {joint.upper_rad:g} rad"
    return Reason(
        "limit", f"{name} is at {present_rad:.2f} rad, outside its limits ({limits}): bring it there by hand first"
    )


def _held(state: State, names: frozenset[str], now: float) -> State:
    """Return the state in which these joints have torque; new ones are held where they are."""
    goals = {**state.goals, **{name: moving.measured(state, name) for name in names - state.on}}
    return replace(state, on=state.on | names, goals=goals, unread=state.unread - names, switched=now)


def _refusal(state: State, event: Torque, now: float) -> Reason | None:
    command = event.command
    links = (
        _form(state, event, now),
        _holder(state, event),
        _rest(state, event, now) if command.on else None,
        stored.busy(state, now) if command.on else None,
        _known(state, now),
    )
    return next((why for why in links if why), None)


def _form(state: State, event: Torque, now: float) -> Reason | None:
    if event.remote and not event.answerable:
        return Reason("query_first", "switching torque from another machine is a query, not a put")
    if not now - event.received <= LATE_S:
        return Reason("late", f"this command came {now - event.received:.1f} s after it was sent; send it again")
    named = event.command.joints
    if unknown := "; ".join(why.text for name in named[:MOST_NAMED] if (why := state.body.unknown(name))):
        return Reason("unknown_name", unknown)
    everything = not named or state.body.joints.keys() <= set(named)
    if everything and not event.command.on and not event.command.confirmed:
        falls = "without torque the robot falls: hold it, then say that all of it is meant (confirmed)"
        return Reason("confirm", falls)
    return None


def _holder(state: State, event: Torque) -> Reason | None:
    live, lease = state.leases.live, event.command.lease
    if live is not None and (lease == live.id or (event.source == live.source and not lease)):
        return None
    if lease:
        return not_live(state.leases, lease)
    return Reason("held", f"held by {live.source}; stop it first", holder=live.source) if live is not None else None


def _rest(state: State, event: Torque, now: float) -> Reason | None:
    held = state.leases
    if held.estop:
        return latched(held)
    if not event.received > held.stopped:
        return STOP_CAME
    return servos_trouble(state, now)


def _known(state: State, now: float) -> Reason | None:
    """Refuse until the torque of servos is known."""
    return None if state.adopted else servos_trouble(state, now) or NOT_ADOPTED


def _switch_events(state: State, source: str, names: Iterable[str], *, on: bool) -> tuple[Happened, ...]:
    changed = [name for name in state.body.joints if name in set(names)]
    if not changed:
        return ()
    which = "all joints" if len(changed) == len(state.body.joints) else ", ".join(changed)
    verb = "on" if on else "off"
    return (Happened(kind="torque", text=f"{source} switched the torque of {which} {verb}"),)


def _reply(reason: str = "", *troubles: Reason) -> Reply:
    """Return an accepting reply, with the troubles that remain."""
    return Reply(message=CommandReply(accepted=True, reason=reason, code=troubles[0].code if troubles else ""))
