"""One capability as the supervisor keeps it: its process, its phase, its past."""

from lbr.executive.planning.process_specs import ProcessSpec
from lbr.executive.processes.process_host import Child
from lbr.executive.processes.starvation import Look
from lbr.messages.system import CapabilityPhase


class ManagedProcess:
    """`reason` is about now, with its `code`; `final_report` is what was said of an end to come; `last_end` how it last
    ended unasked.

    `suspect` is the first look at its threads in a silence, `newest` the last, `look_at` when to look again, and
    `usual` the last look at how much it waits.  `told` is the phase and the reason that people know; `tell_at` is when
    they are told of a start that does not settle.
    """

    def __init__(self, unit: ProcessSpec) -> None:
        self.unit = unit
        self.phase: CapabilityPhase = "waiting"
        self.reason = ""
        self.code: str = ""
        self.child: Child | None = None
        self.restarts = 0
        self.deaths: tuple[float, ...] = ()
        self.started_at = 0.0
        self.beat_at = 0.0
        self.suspect: Look | None = None
        self.newest: Look | None = None
        self.look_at = 0.0
        self.usual: Look | None = None
        self.said: tuple[str, str, str] | None = None
        self.told = ("", "")
        self.settled_at = 0.0
        self.tell_at: float | None = None
        self.final_report = ""
        self.last_end = ""
        self.end_code: str = ""
        self.due_at: float | None = 0.0
        self.kill_at: float | None = None
        self.hung = self.taken_along = False
        self.wanted = True
        self.counts: dict[str, int] = {}
        self.rates: dict[str, float] = {}
        self.counted_at = 0.0
