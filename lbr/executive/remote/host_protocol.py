"""The messages between the executive and the agent on another machine: a report, answered with the share."""

from hashlib import blake2b

import msgspec
from msgspec import Raw, Struct

from lbr.executive.planning.process_specs import ProcessSpec
from lbr.messages.codes import ReasonCode
from lbr.messages.system import CapabilityStatus, Event

REPORT_S = 0.2
LOST_S = 2.0
"""An agent without an answer for this long ends its share; one whose link is lost ends it at once."""
GONE_S = 3.0
"""An agent without a report for this long is gone; a lost link or a dead agent counts at once."""
TOLD = frozenset(["started", "recovered", "degraded", "stopped", "crashed", "hung", "ended", "failed", "need_lost"])
"""The reports of a supervisor about its processes; no others are accepted from an agent."""
MOST_EVENTS = 16
LONGEST_TEXT = 500


class Learnt(Struct, frozen=True, kw_only=True):
    """Rows that a capability has learnt, by table: to be stored."""

    name: str
    rows: dict[str, Raw]


class HostReport(Struct, frozen=True, kw_only=True):
    """The state of a share of the robot: `agent` identifies one run of an agent, `where` describes its place for
    people.

    `share` is the mark of its share. `events` and `learnt` are repeated until they are answered.
    """

    agent: str
    where: str
    share: str = ""
    states: tuple[CapabilityStatus, ...] = ()
    events: tuple[Event, ...] = ()
    learnt: tuple[Learnt, ...] = ()
    leaving: bool = False


class Placed(Struct, frozen=True, kw_only=True):
    """A process of a share; `restarts` counts the requests to restart it."""

    unit: ProcessSpec
    restarts: int = 0


class HostShare(Struct, frozen=True, kw_only=True):
    """The answer: `units` are sent if the agent has others. `ended`: the robot shuts down, and its processes end."""

    accepted: bool
    code: ReasonCode = ""
    reason: str = ""
    version: str = ""
    ended: bool = False
    share: str = ""
    units: tuple[Placed, ...] | None = None


def mark(units: tuple[Placed, ...]) -> str:
    """Return the mark that identifies a share."""
    return blake2b(msgspec.json.encode(units), digest_size=8).hexdigest()
