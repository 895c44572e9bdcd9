"""What the robot's own console shows once all is up: where the page is, how a phone gets in, what is missing and its
cure."""

from collections.abc import Iterator, Mapping

from lbr.executive.processes.readiness import readiness
from lbr.messages.system import Status

MOST_PARTS = 3
"""Parts that are told with their reason: the first that do not work are mostly why the others do not."""


def lines(status: Status, page: str, no_page: str) -> list[str]:
    """Return the lines; `page` is its address, and where there is none `no_page` says why."""
    known = readiness(status.capabilities)
    shown = [("Page", page or f"none: {no_page}")]
    shown += [("Phone", "type phone, or p: it shows a code to scan")] if page else []
    if status.estop.engaged:
        why = f" ({status.estop.reason})" if status.estop.reason else ""
        shown.append(("Stopped", f"the emergency stop is engaged{why}: reset releases it"))
    shown += _parts("Failed", known.failed)
    shown += _parts("Degraded", known.degraded)
    return [f"{title:<9} {text}" for title, text in shown]


def _parts(title: str, reasons: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    for name, reason in list(reasons.items())[:MOST_PARTS]:
        yield title, f"{name}: {reason}"
        title = ""
    if more := list(reasons)[MOST_PARTS:]:
        yield "", f"and {', '.join(more)}: status has the reasons, why says what to type"
