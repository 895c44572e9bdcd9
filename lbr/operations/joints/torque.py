"""Switching the torque of joints: on where they are, off only as somebody means it."""

from collections.abc import Iterable, Mapping

from msgspec.structs import replace

from lbr.messages.leases import DEAD_LEASE, CommandReply
from lbr.operations.joints import moving, stored
from lbr.operations.joints.ending import Decision, end_what_is_over, setpoint
from lbr.operations.joints.state import State, Torque, joint_trouble, position_rad, servos_trouble
from lbr.operations.leasing.acceptance import why_dead
from lbr.operations.leasing.state import LATE_S, Happened, Reply

MOST_TOLD = 3


def switch(state: State, event: Torque, now: float) -> Decision:
    """Refuse to switch the torque, or do it, and say so."""
    if why := _refusal(state, event, now):
        return state, (_reply(why, accepted=False),)
    names = event.command.joints or tuple(state.body.joints)
    return _on(state, event, names, now) if event.command.on else _off(state, event, names, now)


def _on(state: State, event: Torque, names: tuple[str, ...], now: float) -> Decision:
    troubles = {name: why for name in names if (why := not_to_be_held(state, name, now))}
    fit = frozenset(names) - troubles.keys()
    told = "; ".join(list(troubles.values())[:MOST_TOLD])
    more = f" (and {len(troubles) - MOST_TOLD} more)" if len(troubles) > MOST_TOLD else ""
    if not fit:
        return state, (_reply(told + more, accepted=False),)
    state = moving.held_again(state)
    new = fit - state.on
    goals = {**state.goals, **{name: moving.measured(state, name) for name in new}}
    strength = {name: one for name, one in state.strength.items() if name not in fit}
    unread = state.unread - fit
    state = replace(state, on=state.on | fit, goals=goals, strength=strength, unread=unread, switched=now)
    outputs = (*setpoint(state), *_told(state, event.source, new, on=True), _reply(told + more))
    return state, outputs


def _off(state: State, event: Torque, names: tuple[str, ...], now: float) -> Decision:
    gone = state.on & frozenset(names)
    left = state.on - gone
    goals = {name: goal for name, goal in state.goals.items() if name in left}
    strength = {name: one for name, one in state.strength.items() if name in left}
    unread = state.unread - frozenset(names)
    state = replace(state, on=left, goals=goals, strength=strength, unread=unread, lost=False)
    state, ended = end_what_is_over(state, now)
    return state, (*setpoint(state), *ended, *_told(state, event.source, gone, on=False), _reply())


def strengthen(state: State, source: str, strengths: Mapping[str, float], now: float) -> Decision:
    """Return the state in which joints have so much torque from now on; those without get it where they are."""
    new = frozenset(strengths) - state.on
    strengths = {**state.strength, **strengths}
    if not new:
        return replace(state, strength=strengths), ()
    goals = {**state.goals, **{name: moving.measured(state, name) for name in new}}
    unread = state.unread - new
    state = replace(state, on=state.on | new, goals=goals, strength=strengths, unread=unread, switched=now)
    return state, _told(state, source, new, on=True)


def not_to_be_held(state: State, name: str, now: float) -> str:
    """Say why a joint cannot be held where it is, or nothing."""
    if why := joint_trouble(state, name, now):
        return why
    here = position_rad(state, name)
    joint = state.body.joints[name]
    if here is None or state.body.beyond_rad(name, here) <= moving.MARGIN_RAD or name in state.on:
        return ""
    limits = f"{joint.lower_rad:g} to {joint.upper_rad:g} rad"
    return f"{name} is at {here:.2f} rad, outside its limits ({limits}): bring it there by hand first"


def _refusal(state: State, event: Torque, now: float) -> str:
    command = event.command
    links = (
        _form(state, event, now),
        _holder(state, event),
        _rest(state, event, now) if command.on else "",
        stored.busy(state, now) if command.on else "",
        _known(state, now),
    )
    return next((why for why in links if why), "")


def _form(state: State, event: Torque, now: float) -> str:
    if event.remote and not event.answerable:
        return "switching torque from another machine is a query, not a put"
    if not now - event.received <= LATE_S:
        return f"this command came {now - event.received:.1f} s after it was sent; send it again"
    named = event.command.joints
    if why := "; ".join(why for name in named[:MOST_TOLD] if (why := state.body.unknown(name))):
        return why
    everything = not named or state.body.joints.keys() <= set(named)
    if everything and not event.command.on and not event.command.confirmed:
        return "without torque the robot falls: hold it, then say that all of it is meant (confirmed)"
    return ""


def _holder(state: State, event: Torque) -> str:
    hold, lease = state.holding.hold, event.command.lease
    if hold is not None and (lease == hold.lease or (event.source == hold.source and not lease)):
        return ""
    if lease:
        return f"{DEAD_LEASE}{why_dead(state.holding, lease)}"
    return f"held by {hold.source}; stop it first" if hold is not None else ""


def _rest(state: State, event: Torque, now: float) -> str:
    held = state.holding
    if held.estop:
        return f"emergency stop: {held.estop_reason or 'no reason given'}; 'reset' releases it"
    if not event.received > held.stopped:
        return "a stop came after this command"
    return servos_trouble(state, now)


def _known(state: State, now: float) -> str:
    """Until it is known which servos have torque, nothing is told to any."""
    return "" if state.adopted else servos_trouble(state, now) or "servos are still being looked for; say it again"


def _told(state: State, source: str, names: Iterable[str], *, on: bool) -> tuple[Happened, ...]:
    changed = [name for name in state.body.joints if name in set(names)]
    if not changed:
        return ()
    which = "all joints" if len(changed) == len(state.body.joints) else ", ".join(changed)
    verb = "on" if on else "off"
    return (Happened(kind="torque", text=f"{source} switched the torque of {which} {verb}"),)


def _reply(reason: str = "", *, accepted: bool = True) -> Reply:
    return Reply(message=CommandReply(accepted=accepted, reason=reason))
