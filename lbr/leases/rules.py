"""The checks of a command by the rules of leases. The first that fails refuses it."""

from math import inf

from msgspec.structs import replace

from lbr.leases.ask import Ask
from lbr.leases.lease import Lease, LeaseTable, M, PersistentSender
from lbr.messages.codes import Reason
from lbr.messages.leases import STOPPED_SINCE

LONGEST_TTL_S = 1.0
STOP_CAME = Reason("stopped", "a stop came after this command")
NOT_KNOWN = "it is not known here; ask for a new one without quoting a lease"
FORGOTTEN = "it is not known any more, as after a restart of what carries it out"
PERSISTENT_S = 0.25
FORGOTTEN_S = 1.0  # after the pause; longer than any command that moves something is under way
MOST_PERSISTENT = 64
EVERYBODY = ""
ASK_FIRST = Reason(
    "query_first",
    "a motion from another machine begins with a query: its answer has the lease that the command then quotes",
)
TWICE = Reason("repeated", "this command came twice, or after a newer one")


def refusal(ask: Ask[M], trouble: Reason | None = None) -> Reason | None:
    """Return the reason for which the rules of leases refuse a command, or None."""
    return form(ask) or holder(ask) or at_rest(ask, trouble)


def form(ask: Ask[M]) -> Reason | None:
    """Check that the requested lifetime is valid, and that the command is not too old."""
    if not 0.0 <= ask.ttl_s <= LONGEST_TTL_S:  # this way round, NaN is outside
        return Reason("bad_value", f"ttl_s {ask.ttl_s:g} is outside 0 to {LONGEST_TTL_S:g}")
    if ask.ttl_s == 0.0:
        return Reason("bad_value", f"ttl_s 0 lets a lease lapse at once: leave it out, or give up to {LONGEST_TTL_S:g}")
    return _not_fresh(ask)


def holder(ask: Ask[M]) -> Reason | None:
    """Check the holder: a quoted lease must be the live one; otherwise the mover must be free, or is taken over."""
    leases, lease, owner = ask.leases, ask.leases.live, ask.quotes
    if ask.request.lease and not (owner is not None and ask.now < owner.expires):  # this way round, NaN means dead
        return not_live(leases, ask.request.lease)
    if why := _not_own(ask) or _waited(ask):
        return why
    if lease is not None and owner is lease:
        return _order(ask, lease)
    takes = ask.request.take_over or (owner is not None and owner.take_over)
    if lease is not None and (not takes or ask.streams):
        return _held(lease, ask.request.source)
    if not (leases.estop or ask.sent > leases.stopped):
        return STOP_CAME
    return None if ask.sent > leases.begun else TWICE


def at_rest(ask: Ask[M], trouble: Reason | None = None) -> Reason | None:
    """Permit only to stand still while the emergency stop is latched, or while the mover is in `trouble`."""
    if not ask.request.moves:
        return None
    if ask.leases.estop:
        return latched(ask.leases)
    if trouble:
        return trouble
    how = persists(ask)
    return Reason("rest_first", f"{how}: {ask.leases.phrasing.rest}") if how else None


def not_live(leases: LeaseTable[M], lease_id: str) -> Reason:
    """Return why a lease that is not live is refused, and how it ended."""
    ended = dict(leases.revoked).get(lease_id)
    if ended is None:
        return Reason("dead_lease", f"lease is dead: {NOT_KNOWN}", note=FORGOTTEN)
    return Reason("dead_lease", f"lease is dead: {ended}", cause=ended.code, note=ended.text)


def latched(leases: LeaseTable[M]) -> Reason:
    """Return why nothing moves while the emergency stop is latched."""
    return Reason("estop", f"emergency stop: {leases.estop_reason or 'no reason given'}; 'reset' releases it")


def _not_fresh(ask: Ask[M]) -> Reason | None:
    """Return a reason if a command is too old to move anything. Standing still is never too old."""
    request = ask.request
    if not request.moves:
        return None
    age_s = ask.now - min(request.received, ask.sent)  # by rounding, a date may lie after the arrival
    if not age_s >= 0.0:
        return Reason("late", "this command has no date that makes sense")
    if not age_s <= request.patience_s:
        return Reason("late", f"this command came {age_s:.1f} s after it was sent; send it again")
    return ASK_FIRST if request.remote and not (request.lease or request.answerable) else None


def _not_own(ask: Ask[M]) -> Reason | None:
    """Check the sender: another sender's clock proves nothing, nor does a lease that it has overheard."""
    owner, request = ask.quotes, ask.request
    if owner is None or not (request.remote and request.source != owner.source and request.moves):
        return None
    return Reason("foreign_lease", f"this lease is {owner.source}'s: ask for one of your own")


def _held(lease: Lease[M], source: str) -> Reason:
    own = lease.source == source
    text = f"held by {lease.source}{', as you do: quote the lease to go on' if own else '; stop it first'}"
    return Reason("held", text, holder=lease.source)


def _waited(ask: Ask[M]) -> Reason | None:
    """Refuse a command that was typed or written before somebody else stopped the robot, however late it is sent.

    A sender's own stops keep their order, whoever passes them or its commands on. Only the sender's clock measures its
    wait, so that the clocks of two machines are never compared.
    """
    request = ask.request
    if ask.leases.estop or not request.moves or request.waited_s == 0.0:
        return None
    at, by = ask.leases.halts.by_others(request.by or request.source)
    if ask.sent - request.waited_s > at:  # this way round, NaN waited too long
        return None
    return Reason("stopped_since", f"{STOPPED_SINCE}{f'by {by}' if by else 'what moves it started over'}")


def _order(ask: Ask[M], lease: Lease[M]) -> Reason | None:
    """Refuse a message that was not sent after the newest one with its lease; standing still always counts."""
    if not ask.request.moves:
        return None
    newest = max(lease.asked_s, lease.renewed)  # this way round, NaN is not a renewal yet
    return None if ask.sent > newest else TWICE


def persists(ask: Ask[M]) -> str:
    """Return how a source sent motion without permission, a pause or less before it sent this; or an empty text."""
    found = ask.leases.persistent.get(ask.request.source) or ask.leases.persistent.get(EVERYBODY)
    return "" if found is None or min(ask.now, ask.sent) >= found.until else found.how  # NaN means now


def note_persistent(ask: Ask[M], how: str) -> LeaseTable[M]:
    """Note a source that goes on sending, so that it moves nothing when its obstacle disappears by itself."""
    leases, source = ask.leases, ask.request.source
    recent = {name: noted for name, noted in leases.persistent.items() if not ask.now >= noted.until + FORGOTTEN_S}
    known = source if source in recent or len(recent) < MOST_PERSISTENT else EVERYBODY
    until = max(min(ask.now, ask.sent) + PERSISTENT_S, recent[known].until if known in recent else -inf)
    return replace(leases, persistent={**recent, known: PersistentSender(until=until, how=how)})


def forget_persistent(leases: LeaseTable[M], source: str) -> LeaseTable[M]:
    """Note a source's report that it has come to rest."""
    return replace(leases, persistent={name: found for name, found in leases.persistent.items() if name != source})
