"""How old a command is, whatever its sender's clock says, and who goes on sending through a stop."""

from math import inf, isfinite

from msgspec.structs import replace

from lbr.messages.codes import Reason
from lbr.operations.leasing.state import Ask, Hold, Holding, Insisting, M, quoted

INSISTING_S = 0.25
MOST_INSISTING = 64
EVERYBODY = ""
ASK_FIRST = Reason(
    "query_first",
    "a motion from another machine begins with a query: its answer has the lease that the command then quotes",
)
TWICE = Reason("repeated", "this command came twice, or after a newer one")


def dated(holding: Holding[M], ask: Ask) -> float:
    """Return when a command was sent at the latest, on our clock.

    A remote sender's clock is read by the quickest message under the same lease: nothing sent later came sooner, so
    what a partition held back cannot pass for new when it heals.
    """
    behind_s = offset_s(ask, quoted(holding, ask))
    return ask.received if behind_s == inf else ask.sender_s + behind_s


def offset_s(ask: Ask, hold: Hold[M] | None) -> float:
    """Return how far the sender's clock is behind ours at most; infinite if that cannot be told."""
    if not (ask.remote and isfinite(ask.sender_s)):
        return inf
    seen_s = ask.received - ask.sender_s
    return seen_s if hold is None or hold.source != ask.source else min(seen_s, hold.offset_s)


def not_fresh(holding: Holding[M], ask: Ask, now: float) -> Reason | None:
    """Return why a command is too old to move anything, or nothing; standing still is never too old."""
    if not ask.moves:
        return None
    age_s = now - min(ask.received, dated(holding, ask))  # by rounding, a date may lie after the arrival
    if not age_s >= 0.0:
        return Reason("late", "this command has no date that makes sense")
    if not age_s <= ask.patience_s:
        return Reason("late", f"this command came {age_s:.1f} s after it was sent; send it again")
    return ASK_FIRST if ask.remote and not (ask.lease or ask.answerable) else None


def insists(holding: Holding[M], source: str, now: float) -> str:
    """Return how a source has been sending motion that it should not, until just now; or nothing."""
    found = holding.insisting.get(source) or holding.insisting.get(EVERYBODY)
    return "" if found is None or now >= found.until else found.how


def note_insisting(holding: Holding[M], source: str, how: str, now: float) -> Holding[M]:
    """Remember who goes on sending, so that the end of what stopped them by itself moves nothing."""
    recent = {name: found for name, found in holding.insisting.items() if not now >= found.until}
    known = source if source in recent or len(recent) < MOST_INSISTING else EVERYBODY
    return replace(holding, insisting={**recent, known: Insisting(until=now + INSISTING_S, how=how)})


def forget_insisting(holding: Holding[M], source: str) -> Holding[M]:
    """Take a source's word that it has come to rest."""
    if source not in holding.insisting:
        return holding
    return replace(holding, insisting={name: found for name, found in holding.insisting.items() if name != source})
