"""The holder of a mover, and the end of its last motion, as links."""

from collections.abc import Iterator

from lbr.messages.drive import DriveState
from lbr.messages.joints import JointsState
from lbr.messages.why import Link
from lbr.why.snapshot import Part, Report, Snapshot

PLANNED = frozenset(
    {"", "done", "idle", "stopped", "time_over", "superseded", "taken_over", "cancelled", "estop", "off_goal"}
)
"""Codes of motion that ended as planned, or for a reason that another link shows."""
REFUSED_S = 60.0
"""A refusal of the last minute is probably the subject of its sender's question."""
RENEWALS = frozenset({"dead_lease", "late", "repeated"})
"""Codes that refuse a message after the end of its motion, which is not a new request."""
ENDED = ("lapsed", "fault", "stopped", "reached", "interval", "superseded", "holder")


def holder(report: Report[DriveState | JointsState], *, moving: bool) -> Iterator[Link]:
    """Yield the holder of a part, which keeps all others from it."""
    by, now, name = report.state.holder, report.now, report.part.name
    if by is None:
        yield report.link("holder", "ok", f"no sender holds '{name}'")
    elif by in {now.asker, now.asked}:
        text = f"{'who asks' if by == now.asker else by} holds '{name}'"
        yield report.link("holder", "ok", text, since=("holder",))
    else:
        text, do = f"{by} holds '{name}'" + (" and moves it" if moving else ""), "stop, then move it; or take it over"
        yield report.link("holder", "held" if moving else "doubt", text, "held", do=do, since=("holder",))


def last(report: Report[DriveState | JointsState]) -> Link:
    """Return how the last motion ended: by a mishap or by another's stop, or as planned, which is only mentioned."""
    state = report.state
    ended = f"its last motion ended: {state.reason}" if state.reason and state.code != "idle" else ""
    if state.holder is not None:
        return report.link("last", "ok", "it does what was asked", since=ENDED)
    stopped = _stopped(report.now, report.part, state.stopped_by) if state.code == "stopped" else ""
    if state.code in PLANNED and not stopped:
        text = "; ".join(filter(None, ("it waits for a command", ended)))
        return report.link("last", "ok", text, since=ENDED)
    text = f"'{report.part.name}': {stopped or ended or f'its last motion ended: {state.code}'}"
    do = f"see what {state.stopped_by} is, then say again what it shall do" if stopped else "say again what it shall do"
    return report.link("last", "past", text, state.code, do=do, since=ENDED)


def _stopped(now: Snapshot, part: Part, by: str) -> str:
    """Return whose motion somebody else stopped last, and how often that happened lately; empty without one."""
    stops = [stop for stop in now.newest(part.name) if stop.kind == "stopped" and stop.about]
    if not by or by == now.asker or not stops or stops[0].about == by:
        return ""
    often = sum((now.ago_s(stop) or 0.0) <= REFUSED_S for stop in stops)
    again = f", the last of {often} stops within a minute" if often > 1 else ""
    return f"the motion of {stops[0].about} was stopped by {by}{again}"


def refusal(now: Snapshot, part: Part) -> Iterator[Link]:
    """Yield a part's last refusal, unless it has accepted a command since, or the stop behind it is over."""
    for event in now.newest(part.name):
        ago_s = now.ago_s(event)
        if event.kind == "holder" or ago_s is None or ago_s > REFUSED_S:
            return
        if event.code == "estop" and now.status is not None and not now.status.estop.engaged:
            return
        if event.kind == "refused" and event.about and event.code not in RENEWALS:
            text, do = f"'{part.name}' refused what was asked last, by {event.text}", "correct that, and try again"
            evidence = "event refused"
            yield Link("refused", part.name, "past", text, event.code, since_s=ago_s, evidence=evidence, do=do)
            return
