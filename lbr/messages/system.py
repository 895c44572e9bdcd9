"""Messages on the system keys `@console`, `@estop`, `@status` and `@event`, and the stamp of every publication."""

from typing import Annotated, Any, Literal

from msgspec import Meta, Struct
from msgspec.structs import force_setattr

from lbr.messages.codes import Reason, ReasonCode
from lbr.messages.plain import one_line

Role = Literal["view", "operate", "admin"]
RANKS: dict[Role, int] = {"view": 0, "operate": 1, "admin": 2}
"""Roles in ascending order: each includes the rights of those before it."""
TokenRole = Literal["view", "operate", "admin", "host"]
"""The rights of a token's holder; `host` is for another machine that runs a share of the robot, and also looks and
stops."""
Count = Annotated[int, Meta(ge=0, le=2**63 - 1)]
CapabilityPhase = Literal["waiting", "starting", "ready", "degraded", "stopping", "stopped", "failed"]


def higher(one: Role, other: Role) -> Role:
    """Return the higher one of two roles."""
    return max(one, other, key=RANKS.__getitem__)


def role_missing(needed: Role, own: Role | None) -> Reason | None:
    """Return why a user with a role may not do what needs another; None if they may."""
    if own is not None and RANKS[own] >= RANKS[needed]:
        return None
    return Reason("role", f"this needs the role '{needed}', and you have '{own or 'none'}'")


class Stamp(Struct, frozen=True, kw_only=True):
    """The publisher, the number of the message since its start, and its monotonic and wall clock.

    `boot`: two monotonic times compare only within one. `seal` proves the writer of a setpoint. `waited_s`: the wait
    before it was sent, as of a typed line. `by`: the original asker. `via`: the door from another machine. `token`: who
    came in there, proven by a seal.
    """

    source: str
    seq: Count
    mono_ns: Count
    wall_ns: Count
    boot: str = ""
    seal: str = ""
    via: str = ""
    token: str = ""
    waited_s: Annotated[float, Meta(ge=0.0)] = 0.0
    by: str = ""

    def __post_init__(self) -> None:
        """Turn the names that a sender chose into one line, as they are shown."""
        if not self.source.isprintable():
            force_setattr(self, "source", one_line(self.source))
        if not self.by.isprintable():
            force_setattr(self, "by", one_line(self.by))


class Event(Struct, frozen=True, kw_only=True):
    """Something happened: its `kind`, its `subject`, and a sentence (`text`). `about`: the sender of the command or
    motion."""

    kind: Annotated[str, Meta(max_length=80)]
    subject: Annotated[str, Meta(max_length=80)]
    text: Annotated[str, Meta(max_length=4000)]
    level: Literal["info", "warning", "error"] = "info"
    wall_ns: int = 0
    data: dict[str, Any] = {}
    code: ReasonCode = ""
    about: str = ""


AcknowledgeS = Annotated[float, Meta(ge=0.1, le=10.0, description="for the device to acknowledge an emergency stop")]


class EstopRequest(Struct, frozen=True, kw_only=True):
    """Latch (`engaged` true) the emergency stop of everything that moves."""

    engaged: bool
    reason: Annotated[str, Meta(max_length=200)] = ""

    def __post_init__(self) -> None:
        """Turn the reason into one line, as a foreign client may have sent it: every console shows it."""
        force_setattr(self, "reason", one_line(self.reason))


class EstopResetCommand(Struct, frozen=True, kw_only=True):
    """Release the emergency stop; by itself this moves nothing."""


class EstopRelease(Struct, frozen=True, kw_only=True):
    """The executive's message to one mover that the emergency stop is reset, and by whom."""

    by: str = ""


class EstopState(Struct, frozen=True, kw_only=True):
    """The latch, and the capabilities whose devices have acknowledged it.

    `overdue`: those of `waiting` whose time limit is over. `text`: the acknowledgements in words.
    """

    engaged: bool
    reason: str
    source: str = ""
    acknowledged: tuple[str, ...] = ()
    waiting: tuple[str, ...] = ()
    overdue: tuple[str, ...] = ()
    text: str = ""


class EstopAcknowledgement(Struct, frozen=True, kw_only=True):
    """One mover's report: `stopped` once its device has acknowledged, within `within_s`."""

    capability: str
    engaged: bool
    stopped: bool
    reason: str = ""
    within_s: AcknowledgeS = 0.5


class LineCommand(Struct, frozen=True, kw_only=True):
    """A console line of a capability that rows wire to `executive.line`."""

    line: Annotated[str, Meta(min_length=1, max_length=250)]


class Hold(Struct, frozen=True, kw_only=True):
    """The renewal that keeps a console line's motion: put `payload`, which quotes the lease, on `key`."""

    lease: str
    ttl_s: float
    key: str
    stop_key: str
    result_key: str
    payload: dict[str, Any]
    goal: str = ""
    max_run_s: float = 30.0


class ConsoleResult(Struct, frozen=True, kw_only=True):
    """The result of a console line: a text for people, an exit code (0 done, 1 refused or failed, 2 bad input).

    `reason_code`: why it was refused or failed. `confirm`: the line to send once a person agrees.
    """

    code: int
    text: str
    reason_code: ReasonCode = ""
    cause: ReasonCode = ""
    hold: Hold | None = None
    data: Any = None
    confirm: str = ""


class CapabilityStatus(Struct, frozen=True, kw_only=True):
    """One capability as the executive sees it; `rates_hz` are its outputs' rates by its own count. `reason`: that of
    its present phase. `last_end`: its last unrequested end, with `end_code`. `host`: the other machine that it runs on;
    empty: the robot's. `process`: the one that it shares; `pid`, CPU and memory are then those of all in it."""

    name: str
    kind: str
    phase: CapabilityPhase
    pid: int | None
    restarts: int
    uptime_s: float | None
    reason: str
    rates_hz: dict[str, float]
    cpu_percent: float | None = None
    memory_mb: float | None = None
    nice: int | None = None
    last_end: str = ""
    host: str = ""
    code: ReasonCode = ""
    end_code: ReasonCode = ""
    process: str = ""


class Status(Struct, frozen=True, kw_only=True):
    """The whole robot at a glance; `problem_codes` are those of its `problems`, in order.

    `degraded`: the parts that work only partly, with reasons, once the robot is ready.
    """

    robot: str
    profile: str
    ready: bool
    pid: int
    uptime_s: float
    estop: EstopState
    capabilities: tuple[CapabilityStatus, ...]
    problems: tuple[str, ...] = ()
    problem_codes: tuple[ReasonCode, ...] = ()
    revision: int = 0
    degraded: dict[str, str] = {}
