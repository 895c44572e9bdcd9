"""What an accepted command does: it begins to hold the base, goes on, changes, or is offered a lease to confirm."""

from math import copysign, inf, isnan, nan

from msgspec.structs import replace

from lbr.messages.leases import CommandReply
from lbr.messages.motors import MotorSetpoint
from lbr.operations.drive import goals
from lbr.operations.drive.acceptance import intent, notes, refusal, streams
from lbr.operations.drive.asked import moves, power_of, towards_deg, what
from lbr.operations.drive.ending import Decision, drop_offers, end, end_all, result, tell_holder
from lbr.operations.drive.freshness import dated, forget_insisting, insists, note_insisting, offset_s, quoted
from lbr.operations.drive.state import Command, Hold, Outputs, Reply, Setpoint, State, Stop, offered
from lbr.operations.drive.wheels import next_wheels, tell

LAPSE_AHEAD_ROUNDS = 1.5
"""A lapse is noticed by the loop, up to a round late, and takes a moment to reach the motors."""
MOST_OFFERS = 8


def command(state: State, event: Command, now: float) -> Decision:
    """Refuse a command, or do what it wants."""
    wanted = intent(state, event.command)
    if wanted == "stop":
        return stop(state, Stop(source=event.source, received=event.received), now)
    if why := refusal(state, event, now):
        return _refuse(state, event, why, now)
    if wanted == "renewal":
        return _renew(state, event, now)
    if wanted == "change":
        return _change(state, event, now)
    return _offer(state, event, now) if wanted == "new" and event.remote else _begin(state, event, now)


def stop(state: State, event: Stop, now: float) -> Decision:
    """Stand still, whoever says so; what was sent before it begins nothing any more."""
    sent = min(now, event.received)  # this way round, NaN means now
    state = forget_insisting(replace(state, stopped=max(state.stopped, sent)), event.source)
    why = f"stopped by {event.source}" + (f": {event.reason}" if event.reason else "")
    state, said = end_all(state, "stopped", why, now)
    return state, (*said, Reply(message=CommandReply(accepted=True, reason="stopped")))


def drive(state: State, now: float) -> Decision:
    """Say what the motors are to do now."""
    state = next_wheels(state, now)
    lease = state.hold.lease if state.hold else ""
    setpoint = Setpoint(message=MotorSetpoint(left=state.left, right=state.right, lease=lease))
    state, said = tell(state, now)
    return state, (setpoint, *said)


def _refuse(state: State, event: Command, why: str, now: float) -> Decision:
    reply = Reply(message=CommandReply(accepted=False, reason=why), late=bool(event.command.lease))
    if moves(event.command) and (how := _insisting(state, event, now)):
        state = note_insisting(state, event.source, how, now)
    return state, (reply,)


def _insisting(state: State, event: Command, now: float) -> str:
    """Return how a refused command goes on when it should not, or nothing."""
    if state.estop:
        return "commands went on through the emergency stop"
    if state.hold is not None and streams(state.hold, event):
        return "commands went on without quoting their lease"
    return insists(state, event.source, now)


def _renew(state: State, event: Command, now: float) -> Decision:
    assert state.hold is not None
    return _accept(state, replace(_quoting(state, state.hold, event), ttl_s=_ttl_s(state, event)), event, now)


def _change(state: State, event: Command, now: float) -> Decision:
    held = state.hold
    assert held is not None
    ended: Outputs = () if held.goal is None else (result(held.goal, "superseded", "another command came", now),)
    hold = replace(_new_hold(state, event, now), lease=held.lease, source=held.source)
    hold = replace(hold, said=max(held.said, hold.said))
    state, accepted = _accept(state, _quoting(state, hold, event), event, now)
    state, driven = drive(state, now)
    return state, ended + accepted + driven


def _begin(state: State, event: Command, now: float) -> Decision:
    """Hold the base from now on; whoever held it does so no more."""
    before, offer = state.hold, offered(state, event.command.lease)
    source = offer.source if offer else event.source
    why = f"taken over by {source}" if before else ""
    state, ended = end(state, "superseded", why, now, heir=source) if before else (state, ())
    state, hold, replaced = _first_hold(state, event, now)
    state, accepted = _accept(replace(state, begun=max(state.begun, hold.said)), hold, event, now)
    state, told = tell_holder(state, now, took=source, lost=before.source if before else "", why=why)
    state, driven = drive(state, now)
    return state, ended + replaced + accepted + told + driven


def _first_hold(state: State, event: Command, now: float) -> tuple[State, Hold, Outputs]:
    """Return what a command begins with: a lease of its own, or the offered one that it confirms."""
    hold, offer = _new_hold(state, event, now), offered(state, event.command.lease)
    if offer is None:
        return state, hold, ()
    hold = _quoting(state, replace(hold, lease=offer.lease, source=offer.source), event)
    state = replace(state, offers=tuple(one for one in state.offers if one is not offer))
    if offer.goal is None:
        return state, hold, ()
    if hold.goal is not None and what(offer.command) == what(event.command):
        return state, replace(hold, goal=replace(hold.goal, goal=offer.goal.goal)), ()
    return state, hold, (result(offer.goal, "superseded", "another command came", now),)


def _offer(state: State, event: Command, now: float) -> Decision:
    """Promise a lease that moves nothing until it is quoted: only that proves that the command was not held back."""
    own = tuple(offer for offer in state.offers if offer.source == event.source)
    oldest = state.offers[:1] if len(state.offers) >= MOST_OFFERS else ()
    state, dropped = drop_offers(state, own or oldest, "superseded", "another command came", now)
    offer = _new_hold(state, event, now)
    offer = replace(offer, expires=now + offer.ttl_s, offset_s=offset_s(event, None))
    return replace(state, offers=(*state.offers, offer)), (*dropped, _yes(state, offer, event, now))


def _accept(state: State, hold: Hold, event: Command, now: float) -> Decision:
    since = now if isnan(hold.renewed) else hold.renewed
    hold = replace(hold, expires=since + hold.ttl_s - _ahead_s(state, hold.ttl_s))
    return replace(state, hold=hold, reason=""), (_yes(state, hold, event, now),)


def _yes(state: State, hold: Hold, event: Command, now: float) -> Reply:
    reason = notes(state, event.command, now) if moves(event.command) else ""
    goal = hold.goal.goal if hold.goal else ""
    return Reply(
        message=CommandReply(accepted=True, reason=reason, lease=hold.lease, ttl_s=hold.ttl_s, goal=goal),
    )


def _quoting(state: State, hold: Hold, event: Command) -> Hold:
    """Return a hold whose lease was quoted; it lives from when that was sent."""
    known = quoted(state, event)
    assert known is not None
    renewed = max(dated(state, event), known.renewed)  # this way round, NaN is no renewal yet
    own_s = offset_s(event, known) if event.source == known.source else inf
    return replace(hold, renewed=renewed, offset_s=min(known.offset_s, own_s))


def _new_hold(state: State, event: Command, now: float) -> Hold:
    asked = event.command
    goal = goals.start(asked, event.new_goal, state, now) if goals.bounded(asked) else None
    return Hold(
        lease=event.new_lease,
        source=event.source,
        command=asked,
        power=power_of(asked, state.settings),
        angle_deg=towards_deg(asked) if goal is None or goal.turn is None else copysign(90.0, goal.turn.asked_deg),
        ttl_s=_ttl_s(state, event),
        expires=nan,
        changed=now,
        said=dated(state, event),
        goal=goal,
    )


def _ahead_s(state: State, ttl_s: float) -> float:
    """Return how much sooner a lease is over, so that the wheels stand, at the loop's pace, within the time it gave."""
    return min(LAPSE_AHEAD_ROUNDS / state.settings.rate_hz, ttl_s / 5)


def _ttl_s(state: State, event: Command) -> float:
    return state.settings.ttl_s if event.command.ttl_s is None else event.command.ttl_s
