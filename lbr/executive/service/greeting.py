"""The greeting of the robot's own console once all parts run: page and phone, what is missing and its cure."""

from collections.abc import Iterator, Mapping

from lbr.executive.processes.readiness import readiness
from lbr.messages.system import Status

MOST_PARTS = 3
"""The number of parts that are shown with their reason: the first failures usually cause the others."""


def lines(status: Status, page: str, no_page: str) -> list[str]:
    """Return the lines. `page` is its address; without one, `no_page` is the reason."""
    known = readiness(status.capabilities)
    entries = [("Page", page or f"none: {no_page}")]
    entries += [("Phone", "type phone, or p: it shows a code to scan")] if page else []
    if status.estop.engaged:
        why = f" ({status.estop.reason})" if status.estop.reason else ""
        entries.append(("Stopped", f"the emergency stop is engaged{why}: reset releases it"))
    entries += _parts("Failed", known.failed)
    entries += _parts("Degraded", known.degraded)
    return [f"{title:<9} {text}" for title, text in entries]


def _parts(title: str, reasons: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    for name, reason in list(reasons.items())[:MOST_PARTS]:
        yield title, f"{name}: {reason}"
        title = ""
    if more := list(reasons)[MOST_PARTS:]:
        yield "", f"and {', '.join(more)}: status has the reasons, why shows what to type"
