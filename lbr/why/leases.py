"""Who holds what moves, and how its last motion ended, as links."""

from collections.abc import Iterator

from lbr.messages.why import Link
from lbr.why.snapshot import Part, Snapshot

PLANNED = frozenset(
    {"", "done", "idle", "stopped", "time_over", "superseded", "taken_over", "cancelled", "estop", "off_goal"}
)
"""Codes of motion that came to an end as it was meant to, or by what another link tells."""
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
    elif by == now.asker:
        yield Link(
            name="holder",
            about=part.name,
            state="ok",
            text=f"who asks holds '{part.name}'",
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


def last(now: Snapshot, part: Part, by: str | None, code: str, reason: str, topic: str, age_s: float | None) -> Link:
    """Return how the last motion ended: a mishap is told, what was planned only mentioned."""
    mishap = by is None and code not in PLANNED
    ended = reason and code != "idle"
    text = f"its last motion ended: {reason}" if ended else "nothing is asked of it"
    return Link(
        name="last",
        about=part.name,
        state="past" if mishap else "ok",
        text=f"'{part.name}': {text}" if mishap else text,
        code=code if mishap else "",
        since_s=now.since_s(part.name, ENDED),
        age_s=age_s,
        evidence=topic,
        do="say again what it shall do" if mishap else "",
    )
