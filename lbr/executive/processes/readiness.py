"""The meaning of "ready": every capability is ready, or reports at once why not, and none has failed. Pure."""

from collections.abc import Iterable

from msgspec import Struct

from lbr.messages.system import CapabilityStatus

LONGEST_TEXT = 2000
"""An event's text may have 4000 characters."""


class Readiness(Struct, frozen=True):
    """The capabilities that keep the robot from being ready (`failed`) or work only partly, with the reasons."""

    failed: dict[str, str] = {}
    degraded: dict[str, str] = {}

    @property
    def ready(self) -> bool:
        """Return whether the robot is ready."""
        return not self.failed

    def words(self, after_s: float) -> str:
        """Return the state in one line, once everything runs or has given up."""
        first = f"all up after {after_s:.1f} s" if self.ready else f"not ready after {after_s:.1f} s"
        return "; ".join([first, *_lines("", self.failed), *_lines("degraded: ", self.degraded)])[:LONGEST_TEXT]


def readiness(capabilities: Iterable[CapabilityStatus]) -> Readiness:
    """Return the readiness of a robot whose capabilities have settled: whatever still waits on this machine waits for a
    failed one.

    A capability that waits for another machine, or has ended as its restart policy allows, only degrades the robot.
    """
    failed: dict[str, str] = {}
    degraded: dict[str, str] = {}
    for status in capabilities:
        if status.phase == "failed" or (status.phase == "waiting" and not status.host):
            failed[status.name] = status.reason or status.phase
        elif status.phase == "degraded":
            degraded[status.name] = status.reason or status.phase
        elif status.phase != "ready":
            degraded[status.name] = f"{status.phase}: {status.reason}" if status.reason else status.phase
    return Readiness(failed, degraded)


def _lines(prefix: str, reasons: dict[str, str]) -> list[str]:
    return [f"{prefix}{name}: {reason}" for name, reason in reasons.items()]
