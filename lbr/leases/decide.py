"""The effects of commands and stops. A command is refused, renews, changes, begins or is offered a lease."""

from math import inf, isnan

from msgspec.structs import replace

from lbr.leases.ask import Ask
from lbr.leases.ending import Decision, Endings, drop_offers, end, end_all, report_holder
from lbr.leases.lease import IDLE, Ended, EstopChanged, Lease, LeaseTable, M, Reply, Stop
from lbr.leases.rules import forget_persistent, note_persistent, persists
from lbr.messages.codes import Reason
from lbr.messages.leases import CommandReply, refused

MOST_OFFERS = 8
ANOTHER = Reason("superseded", "another command came")
STOPPED = Reply(message=CommandReply(accepted=True, reason="stopped"))


def refuse(ask: Ask[M], why: Reason) -> tuple[LeaseTable[M], Reply]:
    """Refuse a command, and remember a sender that goes on without permission."""
    how = _persists(ask) if ask.request.moves else ""
    leases = note_persistent(ask, how) if how else ask.leases
    return leases, Reply(message=refused(why), late=bool(ask.request.lease))


def renew(ask: Ask[M]) -> LeaseTable[M]:
    """Renew the lease of the motion, which goes on unchanged."""
    leases = ask.leases
    assert leases.live is not None
    return _keep(leases, replace(_quoting(ask, leases.live), ttl_s=ask.ttl_s), ask.now)


def grant(leases: LeaseTable[M], ask: Ask[M], motion: M) -> Decision[M]:
    """Begin a motion, change it under the same lease, or offer a lease that has to be quoted."""
    steps = {"change": _change, "offer": _offer, "begin": _begin}
    return steps[ask.wants](leases, ask, motion)


def lent(leases: LeaseTable[M], ask: Ask[M]) -> Lease[M]:
    """Return the lease in the answer to an accepted command."""
    lease = leases.offers[-1] if ask.wants == "offer" else leases.live
    assert lease is not None
    return lease


def accepted(lease: Lease[M], note: Reason | None = None, goal: str = "") -> Reply:
    """Answer with a lease or an offer, a note for its holder, and the name of its goal."""
    reason, code = (note.text, note.code) if note else ("", "")
    message = CommandReply(accepted=True, reason=reason, code=code, lease=lease.id, ttl_s=lease.ttl_s, goal=goal)
    return Reply(message=message)


def _change(leases: LeaseTable[M], ask: Ask[M], motion: M) -> Decision[M]:
    """Change the motion under the same lease; the former goal is superseded, but the lease goes on."""
    held = leases.live
    assert held is not None
    lease = replace(_new_lease(ask, motion), id=held.id, source=held.source)
    lease = replace(lease, asked_s=max(held.asked_s, lease.asked_s))
    ended = Ended(lease=held, how="superseded", why=ANOTHER, held=False)
    return _keep(leases, _quoting(ask, lease), ask.now), (ended,)


def _begin(leases: LeaseTable[M], ask: Ask[M], motion: M) -> Decision[M]:
    """Give the lease to the new holder; the previous one loses it."""
    before, offer, now = leases.live, ask.quotes, ask.now
    source = offer.source if offer else ask.request.source
    why = Reason("taken_over", f"taken over by {source}")
    lease = _new_lease(ask, motion)
    replaced: Endings[M] = ()
    if offer is not None:
        lease = _quoting(ask, replace(lease, id=offer.id, source=offer.source))
        if ask.confirms is None:
            replaced = (Ended(lease=offer, how="superseded", why=ANOTHER, held=False),)
        leases = replace(leases, offers=tuple(one for one in leases.offers if one is not offer))
    leases, ended = end(leases, "superseded", why, now, heir=source)
    leases = _keep(replace(leases, begun=max(leases.begun, lease.asked_s)), lease, now)
    lost, cause = (before.source, why) if before else ("", None)
    leases, told = report_holder(leases, now, took=source, lost=lost, why=cause)
    return leases, ended + replaced + told


def _offer(leases: LeaseTable[M], ask: Ask[M], motion: M) -> Decision[M]:
    """Promise a lease that moves nothing until it is quoted: only that proves that the command was not delayed.

    The newest of the offers is the new one.
    """
    own = tuple(offer for offer in leases.offers if offer.source == ask.request.source)
    oldest = leases.offers[:1] if len(leases.offers) >= MOST_OFFERS else ()
    leases, dropped = drop_offers(leases, own or oldest, "superseded", ANOTHER)
    made = _new_lease(ask, motion)
    made = replace(made, expires=ask.now + made.ttl_s, offset_s=ask.behind_s)
    return replace(leases, offers=(*leases.offers, made)), dropped


def stop(leases: LeaseTable[M], event: Stop, now: float) -> Decision[M]:
    """Stand still for any sender; a command that was sent before the stop begins nothing."""
    sent = min(now, event.received)  # this way round, NaN means now
    own = event.own or (leases.live is not None and leases.live.source == event.source)
    if event.whole or not own:
        leases = replace(leases, halts=leases.halts.noted(sent, event.by or event.source))
    if sent >= leases.stopped:
        leases = replace(leases, stopped=sent, stopped_by=event.source)
    leases = forget_persistent(leases, event.source)
    if event.lost and leases.live is not None and leases.live.source == event.source:
        gone = Reason("holder_gone", event.reason or "the sender that wanted it is gone")
        return end_all(leases, "lapsed", gone, now)
    why = f"stopped by {event.source}" + (f": {event.reason}" if event.reason else "")
    return end_all(leases, "stopped", Reason("stopped", why), now)


def latch(leases: LeaseTable[M], event: EstopChanged, now: float) -> Decision[M]:
    """Latch or release the emergency stop; commands sent before either begin nothing any more."""
    stopped = max(leases.stopped, now)
    leases = replace(leases, estop=event.engaged, estop_reason=event.reason, stopped=stopped, stopped_by="")
    by = event.by or ("the emergency stop" if event.engaged else "the emergency stop's reset")
    leases = replace(leases, halts=leases.halts.noted(now, by))
    why = f"emergency stop: {event.reason or 'no reason given'}" if event.engaged else "the emergency stop was reset"
    return end_all(leases, "fault", Reason("estop", why), now)


def with_motion(leases: LeaseTable[M], motion: M) -> LeaseTable[M]:
    """Return the leases with the present state of the holder's motion."""
    assert leases.live is not None
    return replace(leases, live=replace(leases.live, motion=motion))


def _persists(ask: Ask[M]) -> str:
    """Return how the sender of a refused command goes on without permission, or an empty text.

    A command that was under way when the emergency stop was latched does not count: its sender did not know of it yet.
    """
    leases = ask.leases
    if leases.estop and not ask.sent < leases.stopped:  # this way round, NaN goes on
        return "commands went on through the emergency stop"
    if ask.streams:
        return "commands went on without quoting their lease"
    return persists(ask)


def _keep(leases: LeaseTable[M], lease: Lease[M], now: float) -> LeaseTable[M]:
    """Date a lease from its last quotation, otherwise its acceptance; it ends a little before its lifetime is over."""
    since = now if isnan(lease.renewed) else lease.renewed
    ahead_s = min(leases.ahead_s, lease.ttl_s / 5)
    return replace(leases, live=replace(lease, expires=since + lease.ttl_s - ahead_s), reason=IDLE)


def _quoting(ask: Ask[M], lease: Lease[M]) -> Lease[M]:
    """Return a lease that was quoted, dated from the time at which the quotation was sent."""
    known = ask.quotes
    assert known is not None
    renewed = max(ask.sent, known.renewed)  # this way round, NaN is not a renewal yet
    own_s = ask.behind_s if ask.request.source == known.source else inf
    return replace(lease, renewed=renewed, offset_s=min(known.offset_s, own_s))


def _new_lease(ask: Ask[M], motion: M) -> Lease[M]:
    request = ask.request
    return Lease(
        id=request.new_lease,
        source=request.source,
        content=request.content,
        motion=motion,
        ttl_s=ask.ttl_s,
        changed=ask.now,
        asked_s=ask.sent,
        take_over=request.take_over,
    )
