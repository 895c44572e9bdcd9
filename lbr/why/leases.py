"""Who holds what moves, and how its last motion ended, as links."""

from collections.abc import Iterator

from lbr.messages.why import Link
from lbr.why.snapshot import Part, Snapshot

PLANNED = frozenset(
    {"", "done", "idle", "stopped", "time_over", "superseded", "taken_over", "cancelled", "estop", "off_goal"}
)
"""Codes of motion that came to an end as it was meant to, or by what another link tells."""
REFUSED_S = 60.0
"""What was refused within a minute is still what its sender asks about."""
RENEWALS = frozenset({"dead_lease", "late", "repeated"})
"""Codes with which what goes on after its motion's end is refused: that is no wish of anyone's."""
ENDED = ("lapsed", "fault", "stopped", "reached", "interval", "superseded", "holder")


def holder(
    now: Snapshot, part: Part, by: str | None, topic: str, age_s: float | None, *, moving: bool
) -> Iterator[Link]:
    """Yield who holds a part: another that moves it keeps all others from it."""
    since_s = now.since_s(part.name, ("holder",))
    if by is None:
        yield Link(
            name="holder",
            about=part.name,
            state="ok",
            text=f"no sender holds '{part.name}'",
            age_s=age_s,
            evidence=topic,
        )
    elif by in {now.asker, now.asked}:
        yield Link(
            name="holder",
            about=part.name,
            state="ok",
            text=f"{'who asks' if by == now.asker else by} holds '{part.name}'",
            since_s=since_s,
            age_s=age_s,
            evidence=topic,
        )
    else:
        yield Link(
            name="holder",
            about=part.name,
            state="held" if moving else "doubt",
            text=f"{by} holds '{part.name}'" + (" and moves it" if moving else ""),
            code="held",
            since_s=since_s,
            age_s=age_s,
            evidence=topic,
            do="stop, then move it; or take it over",
        )


def last(
    now: Snapshot,
    part: Part,
    by: str | None,
    code: str,
    reason: str,
    topic: str,
    age_s: float | None,
    *,
    stopped_by: str = "",
) -> Link:
    """Return how the last motion ended: a mishap, or a stop by another, is told, what was planned only mentioned."""
    stopped = _stopped(now, part, stopped_by) if by is None and code == "stopped" else ""
    mishap = by is None and (code not in PLANNED or bool(stopped))
    ended = f"its last motion ended: {reason}" if reason and code != "idle" else ""
    rests = "; ".join(filter(None, ("it waits for a command", ended))) if by is None else "it does what was asked"
    text = (stopped or ended or f"its last motion ended: {code}") if mishap else rests
    return Link(
        name="last",
        about=part.name,
        state="past" if mishap else "ok",
        text=f"'{part.name}': {text}" if mishap else text,
        code=code if mishap else "",
        since_s=now.since_s(part.name, ENDED),
        age_s=age_s,
        evidence=topic,
        do=f"see what {stopped_by} is, then say again what it shall do"
        if stopped
        else "say again what it shall do"
        if mishap
        else "",
    )


def _stopped(now: Snapshot, part: Part, by: str) -> str:
    """Return whose motion another than its sender stopped last, and how often it did of late; empty if that was no
    other."""
    said = [one for one in now.newest(part.name) if one.kind == "stopped" and one.about]
    if not by or by == now.asker or not said or said[0].about == by:
        return ""
    often = sum((now.ago_s(one) or 0.0) <= REFUSED_S for one in said)
    again = f", the last of {often} stops within a minute" if often > 1 else ""
    return f"the motion of {said[0].about} was stopped by {by}{again}"


def refusal(now: Snapshot, part: Part) -> Iterator[Link]:
    """Yield what a part refused last, and why, unless it took another command since."""
    for event in now.newest(part.name):
        ago_s = now.ago_s(event)
        if event.kind == "holder" or ago_s is None or ago_s > REFUSED_S:
            return
        if event.kind == "refused" and event.about and event.code not in RENEWALS:
            yield Link(
                name="refused",
                about=part.name,
                state="past",
                text=f"'{part.name}' refused what was asked last, by {event.text}",
                code=event.code,
                since_s=ago_s,
                evidence="event refused",
                do="mend that, and say it again",
            )
            return
