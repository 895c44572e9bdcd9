"""The decision about a command: refused, or it renews, changes, begins or is offered a lease to confirm; and stops."""

from collections.abc import Callable
from math import inf, isnan
from typing import Literal

from msgspec.structs import replace

from lbr.messages.codes import Reason
from lbr.messages.leases import CommandReply, refused
from lbr.operations.leasing.ending import Decision, Said, drop_offers, end, end_all, tell_holder
from lbr.operations.leasing.lease import (
    IDLE,
    Ask,
    Ended,
    EstopChanged,
    Hold,
    Holding,
    M,
    Reply,
    Stop,
    confirmed,
    offered,
    quoted,
    streams,
)
from lbr.operations.leasing.rules import Intent, dated, forget_insisting, insists, intent, note_insisting, offset_s

Verdict = Intent | Literal["refused"]
MOST_OFFERS = 8
ANOTHER = Reason("superseded", "another command came")
STOPPED = Reply(message=CommandReply(accepted=True, reason="stopped"))


def judge(
    holding: Holding[M], ask: Ask, refusal: Callable[[Intent], Reason | None], now: float
) -> tuple[Verdict, Holding[M], tuple[Reply, ...]]:
    """Return what becomes of a command, having refused or renewed it if that is all; else `stop` or `grant` follows.

    `refusal` is the kernel's chain for what the command wants. A sender that goes on when it should not is remembered.
    """
    wanted = intent(holding, ask)
    if wanted == "stop":
        return wanted, holding, ()
    if why := refusal(wanted):
        if ask.moves and (how := _insisting(holding, ask, now)):
            holding = note_insisting(holding, ask.source, how, now)
        return "refused", holding, (Reply(message=refused(why), late=bool(ask.lease)),)
    if wanted == "renewal":
        assert holding.hold is not None
        kept = replace(_quoting(holding, holding.hold, ask), ttl_s=_ttl_s(holding, ask))
        return wanted, _keep(holding, kept, now), ()
    return wanted, holding, ()


def grant(holding: Holding[M], ask: Ask, verdict: Verdict, motion: M, now: float) -> Decision[M]:
    """Have a motion begin, go on under the same lease instead of another, or wait for its lease to be quoted."""
    steps = {"change": _change, "offer": _offer, "begin": _begin}
    return steps[verdict](holding, ask, motion, now)


def lent(holding: Holding[M], verdict: Verdict) -> Hold[M]:
    """Return the lease that the answer to an accepted command is about."""
    found = holding.offers[-1] if verdict == "offer" else holding.hold
    assert found is not None
    return found


def accepted(hold: Hold[M], note: Reason | None = None, goal: str = "") -> Reply:
    """Answer with the lease of a hold or an offer, what its holder should know, and the name of its goal."""
    reason, code = (note.text, note.code) if note else ("", "")
    message = CommandReply(accepted=True, reason=reason, code=code, lease=hold.lease, ttl_s=hold.ttl_s, goal=goal)
    return Reply(message=message)


def _change(holding: Holding[M], ask: Ask, motion: M, now: float) -> Decision[M]:
    """Go on under the same lease with another motion; the one before is superseded, but the hold goes on."""
    held = holding.hold
    assert held is not None
    hold = replace(_new_hold(holding, ask, motion, now), lease=held.lease, source=held.source)
    hold = replace(hold, said=max(held.said, hold.said))
    ended = Ended(hold=held, how="superseded", why=ANOTHER, held=False)
    return _keep(holding, _quoting(holding, hold, ask), now), (ended,)


def _begin(holding: Holding[M], ask: Ask, motion: M, now: float) -> Decision[M]:
    """Hold it from now on; whoever held it does so no more."""
    before, offer = holding.hold, offered(holding, ask.lease)
    source = offer.source if offer else ask.source
    why = Reason("taken_over", f"taken over by {source}") if before else None
    hold = _new_hold(holding, ask, motion, now)
    replaced: Said[M] = ()
    if offer is not None:
        hold = _quoting(holding, replace(hold, lease=offer.lease, source=offer.source), ask)
        if confirmed(holding, ask) is None:
            replaced = (Ended(hold=offer, how="superseded", why=ANOTHER, held=False),)
        holding = replace(holding, offers=tuple(one for one in holding.offers if one is not offer))
    holding, ended = end(holding, "superseded", why, now, heir=source) if why else (holding, ())
    holding = _keep(replace(holding, begun=max(holding.begun, hold.said)), hold, now)
    holding, told = tell_holder(holding, now, took=source, lost=before.source if before else "", why=why)
    return holding, ended + replaced + told


def _offer(holding: Holding[M], ask: Ask, motion: M, now: float) -> Decision[M]:
    """Promise a lease that moves nothing until it is quoted: only that proves that the command was not held back.

    The newest of the offers is the one that was made.
    """
    own = tuple(offer for offer in holding.offers if offer.source == ask.source)
    oldest = holding.offers[:1] if len(holding.offers) >= MOST_OFFERS else ()
    holding, dropped = drop_offers(holding, own or oldest, "superseded", ANOTHER)
    made = _new_hold(holding, ask, motion, now)
    made = replace(made, expires=now + made.ttl_s, offset_s=offset_s(ask, None))
    return replace(holding, offers=(*holding.offers, made)), dropped


def stop(holding: Holding[M], event: Stop, now: float) -> Decision[M]:
    """Stand still, whoever says so; what was sent before it begins nothing any more."""
    sent = min(now, event.received)  # this way round, NaN means now
    own = holding.hold is not None and holding.hold.source == event.source
    if event.whole or not own:
        holding = replace(holding, halts=holding.halts.heard(sent, event.source))
    if sent >= holding.stopped:
        holding = replace(holding, stopped=sent, stopped_by=event.source)
    holding = forget_insisting(holding, event.source)
    if event.lost and holding.hold is not None and holding.hold.source == event.source:
        return end_all(
            holding, "lapsed", Reason("holder_gone", event.reason or "the sender that wanted it is gone"), now
        )
    why = f"stopped by {event.source}" + (f": {event.reason}" if event.reason else "")
    return end_all(holding, "stopped", Reason("stopped", why), now)


def latch(holding: Holding[M], event: EstopChanged, now: float) -> Decision[M]:
    """Latch or release the emergency stop; what was sent before either begins nothing any more."""
    stopped = max(holding.stopped, now)
    holding = replace(holding, estop=event.engaged, estop_reason=event.reason, stopped=stopped, stopped_by="")
    by = "the emergency stop" if event.engaged else "the emergency stop's reset"
    holding = replace(holding, halts=holding.halts.heard(now, by))
    why = f"emergency stop: {event.reason or 'no reason given'}" if event.engaged else "the emergency stop was reset"
    return end_all(holding, "fault", Reason("estop", why), now)


def with_motion(holding: Holding[M], motion: M) -> Holding[M]:
    """Return the holding whose holder's motion has come so far."""
    assert holding.hold is not None
    return replace(holding, hold=replace(holding.hold, motion=motion))


def _insisting(holding: Holding[M], ask: Ask, now: float) -> str:
    """Return how a refused command goes on when it should not, or nothing."""
    if holding.estop:
        return "commands went on through the emergency stop"
    if holding.hold is not None and streams(holding.hold, ask):
        return "commands went on without quoting their lease"
    return insists(holding, ask.source, now)


def _keep(holding: Holding[M], hold: Hold[M], now: float) -> Holding[M]:
    """A lease lives from when it was last quoted, or else accepted; it is over a little sooner than it says."""
    since = now if isnan(hold.renewed) else hold.renewed
    ahead_s = min(holding.ahead_s, hold.ttl_s / 5)
    return replace(holding, hold=replace(hold, expires=since + hold.ttl_s - ahead_s), reason=IDLE)


def _quoting(holding: Holding[M], hold: Hold[M], ask: Ask) -> Hold[M]:
    """Return a hold whose lease was quoted; it lives from when that was sent."""
    known = quoted(holding, ask)
    assert known is not None
    renewed = max(dated(holding, ask), known.renewed)  # this way round, NaN is no renewal yet
    own_s = offset_s(ask, known) if ask.source == known.source else inf
    return replace(hold, renewed=renewed, offset_s=min(known.offset_s, own_s))


def _new_hold(holding: Holding[M], ask: Ask, motion: M, now: float) -> Hold[M]:
    return Hold(
        lease=ask.new_lease,
        source=ask.source,
        what=ask.what,
        motion=motion,
        ttl_s=_ttl_s(holding, ask),
        changed=now,
        said=dated(holding, ask),
        take_over=ask.take_over,
    )


def _ttl_s(holding: Holding[M], ask: Ask) -> float:
    return holding.ttl_s if ask.ttl_s is None else ask.ttl_s
