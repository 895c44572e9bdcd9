"""How old a command is, whatever its sender's clock says, and who goes on sending through a stop."""

from math import inf, isfinite

from msgspec.structs import replace

from lbr.operations.drive.asked import moves
from lbr.operations.drive.state import Command, Hold, Insisting, State

LATE_S = 0.3
INSISTING_S = 0.25
MOST_INSISTING = 64
EVERYBODY = ""
ASK_FIRST = "a motion from another machine begins with a query: its answer has the lease that the command then quotes"
TWICE = "this command came twice, or after a newer one"


def dated(state: State, event: Command) -> float:
    """Return when a command was sent at the latest, on our clock.

    A remote sender's clock is read by the quickest message under the same lease: nothing sent later came sooner, so
    what a partition held back cannot pass for new when it heals.
    """
    behind_s = offset_s(event, quoted(state, event))
    return event.received if behind_s == inf else event.sender_s + behind_s


def offset_s(event: Command, hold: Hold | None) -> float:
    """Return how far the sender's clock is behind ours at most; infinite if that cannot be told."""
    if not (event.remote and isfinite(event.sender_s)):
        return inf
    seen_s = event.received - event.sender_s
    return seen_s if hold is None or hold.source != event.source else min(seen_s, hold.offset_s)


def quoted(state: State, event: Command) -> Hold | None:
    """Return the hold or the offer whose lease a command quotes."""
    lease = event.command.lease
    known = (state.hold, *state.offers)
    return next((hold for hold in known if hold is not None and hold.lease == lease), None) if lease else None


def not_fresh(state: State, event: Command, now: float) -> str:
    """Return why a command is too old to move anything, or nothing; standing still is never too old."""
    if not moves(event.command):
        return ""
    patience_s = LATE_S + (2 * state.settings.checks_timeout_s if event.checks else 0.0)
    age_s = now - min(event.received, dated(state, event))  # by rounding, a date may lie after the arrival
    if not age_s >= 0.0:
        return "this command has no date that makes sense"
    if not age_s <= patience_s:
        return f"this command came {age_s:.1f} s after it was sent; send it again"
    return ASK_FIRST if event.remote and not (event.command.lease or event.answerable) else ""


def insists(state: State, source: str, now: float) -> str:
    """Return how a source has been sending motion that it should not, until just now; or nothing."""
    found = state.insisting.get(source) or state.insisting.get(EVERYBODY)
    return "" if found is None or now >= found.until else found.how


def note_insisting(state: State, source: str, how: str, now: float) -> State:
    """Remember who goes on sending, so that the end of what stopped them by itself moves nothing."""
    recent = {name: found for name, found in state.insisting.items() if not now >= found.until}
    known = source if source in recent or len(recent) < MOST_INSISTING else EVERYBODY
    return replace(state, insisting={**recent, known: Insisting(until=now + INSISTING_S, how=how)})


def forget_insisting(state: State, source: str) -> State:
    """Take a source's word that it has come to rest."""
    if source not in state.insisting:
        return state
    return replace(state, insisting={name: found for name, found in state.insisting.items() if name != source})
