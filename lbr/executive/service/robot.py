"""What those who speak for the robot need of the executive."""

from typing import Protocol

from lbr.bus.stamp import Origin
from lbr.console.verbs import ExternalCall, Vocabulary
from lbr.executive.planning.plan import Plan
from lbr.executive.service.pairing import Code
from lbr.messages.system import ConsoleResult, Event, Role, Status


class Robot(Protocol):
    """A running robot; every method may be called from any thread."""

    @property
    def plan(self) -> Plan:
        """Return the plan that runs."""

    @property
    def vocabulary(self) -> Vocabulary:
        """Return the words that can be said."""

    def status(self) -> Status:
        """Return the robot at a glance."""

    def recent_events(self) -> list[Event]:
        """Return the newest events, oldest first."""

    def estop(self, reason: str, source: str) -> ConsoleResult:
        """Latch the emergency stop and wait for the devices."""

    def estop_reset(self, source: str, written_s: float) -> ConsoleResult:
        """Release it, unless another has pressed it since that was written."""

    def shutdown(self, source: str) -> None:
        """Begin the shutdown."""

    def restart(self, name: str) -> None:
        """Restart a capability; InputError if none of that name runs."""

    def pair(self, role: Role, who: str) -> Code:
        """Draw a code by which a device gets a token with a role."""

    def listen_at(self, name: str, host: str, who: str) -> None:
        """Write where a server listens, a setting of its row; RowError or InputError if it may not be."""

    def run_external(self, call: ExternalCall, who: str, origin: Origin, said_s: float) -> ConsoleResult:
        """Start an external command, which is told whose line that was, and when it was written and said."""

    def stop_external(self, name: str, who: str, about: str) -> str:
        """End one."""

    def note(self, kind: str, text: str, about: str = "") -> None:
        """Write down an event."""

    def record(self, kind: str, who: str, text: str) -> None:
        """Put an entry into the audit trail, soon; returns at once."""
