"""A capability in the supervisor: its process, its phase, its history."""

from math import inf

from lbr.executive.planning.process_specs import ProcessSpec
from lbr.executive.processes.process_host import Child
from lbr.executive.processes.starvation import Look
from lbr.messages.system import CapabilityPhase


class Part:
    """A capability and its state; `child` is its process, None without one.

    `reason` and `code` explain its phase. `final_report` announces an end. `last_end` is the last end that was not
    requested. `reported` is a phase that counts once the capability is present on the bus. `announced` are the last
    announced phase and reason. `announce_at` is when an unsettled start is announced. `suspect` is the first look at
    its threads in a silence, `newest` the latest; `look_at` is when to look again. `usual` is the latest look while it
    runs normally, for how long it waits for a processor.
    """

    def __init__(self, spec: ProcessSpec) -> None:
        self.spec = spec
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
        self.reported: tuple[str, str, str] | None = None
        self.announced = ("", "")
        self.settled_at = 0.0
        self.announce_at = inf
        self.final_report = ""
        self.last_end = ""
        self.end_code: str = ""
        self.due_at = 0.0
        self.kill_at = inf
        self.hung = self.taken_along = False
        self.wanted = True
        self.counts: dict[str, int] = {}
        self.rates: dict[str, float] = {}
        self.counted_at = 0.0
