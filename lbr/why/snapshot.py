"""The facts of a robot at one moment: its rows, its status, the newest message of every stream, and recent events."""

from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Generic, Literal, TypeVar

import msgspec
from msgspec import Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.system import CapabilityStatus, Event, Role, Status
from lbr.messages.why import Link, LinkName, LinkState

T = TypeVar("T", bound=Struct)
State_co = TypeVar("State_co", bound=Struct, covariant=True)
ITSELF = "executive"
"""The name in place of a capability for acts of the robot itself."""


class Part(Struct, frozen=True, kw_only=True):
    """A capability by its row and its kind; it `runs` if it is in the robot's plan.

    `inputs`, `setpoints` and `outputs` are the names of their messages by port; `optional` inputs may be unfed.
    """

    name: str
    kind: str
    family: str
    enabled: bool = True
    runs: bool = True
    moves: bool = False
    device: str = ""
    needs: tuple[str, ...] = ()
    inputs: dict[str, str] = {}
    setpoints: dict[str, str] = {}
    outputs: dict[str, str] = {}
    optional: tuple[str, ...] = ()
    settings: dict[str, Any] = {}


class Channel(Struct, frozen=True, kw_only=True):
    """A channel: from `capability.port` to `capability.port`, at most `rate_hz` (None: every message)."""

    source: str
    target: str
    enabled: bool = True
    rate_hz: float | None = None

    @property
    def source_part(self) -> str:
        """Return the capability of its source."""
        return self.source.partition(".")[0]

    @property
    def target_part(self) -> str:
        """Return the capability of its target."""
        return self.target.partition(".")[0]


class JointLimits(Struct, frozen=True, kw_only=True):
    """The limits of a joint, by its row."""

    name: str
    servo: int
    lower_rad: float
    upper_rad: float


class Saying(Struct, frozen=True, kw_only=True):
    """A line of the console: its pattern, its target, and its fields."""

    pattern: str
    target: str
    payload: dict[str, Any] = {}

    @property
    def word(self) -> str:
        """Return the first word of the line."""
        return self.pattern.removeprefix("/").partition("/")[0]

    @property
    def target_part(self) -> str:
        """Return the capability of its target, or `ITSELF`."""
        return self.target.partition(".")[0]


class Facts(Struct, frozen=True, kw_only=True):
    """The content of the rows. `problems` are their faults; then `parts` may lack some.

    `last_start` and `last_shutdown` are the robot's, in ISO 8601. `latched`: its emergency stop is, and will be at its
    next start.
    """

    robot: str
    profile: str = ""
    parts: dict[str, Part] = {}
    channels: tuple[Channel, ...] = ()
    devices: dict[str, str] = {}
    joints: tuple[JointLimits, ...] = ()
    programs: dict[str, bool] = {}
    sayings: tuple[Saying, ...] = ()
    problems: tuple[str, ...] = ()
    last_start: str = ""
    last_shutdown: str = ""
    latched: bool = False
    latched_reason: str = ""

    def say(self, target: str, otherwise: str, **payload: Any) -> str:
        """Return the shortest line for this request, else another way to do it."""
        found = (line for one in self.sayings if one.target == target and (line := _filled(one, payload)))
        return min(found, key=len, default=otherwise)


class LatestMessage(Struct, frozen=True, kw_only=True):
    """The newest message of a stream, with its age (null: its clock cannot be compared with ours)."""

    message: dict[str, Any]
    age_s: float | None = None


class Snapshot(Struct, frozen=True, kw_only=True):
    """A robot at one moment. `executive`: it answers, is silent, or does not run.

    `waited_s` is how long its answer was awaited. `asker` asks, with the role `role`, about the part `asked`.
    `messages` are by topic, such as `drive/state`. `events` are oldest first.
    """

    facts: Facts
    executive: Literal["up", "silent", "down"] = "up"
    waited_s: float = 0.0
    status: Status | None = None
    messages: dict[str, LatestMessage] = {}
    events: tuple[Event, ...] = ()
    wall_ns: int = 0
    asker: str = ""
    role: Role = "admin"
    asked: str = ""

    def unit(self, name: str) -> CapabilityStatus | None:
        """Return the state of a capability's process, None if it is unknown."""
        units = self.status.capabilities if self.status is not None else ()
        return next((one for one in units if one.name == name), None)

    def report(self, part: Part, message: type[T]) -> "Report[T] | None":
        """Return the newest message of this type in a part's streams."""
        for port, name in part.outputs.items():
            newest = self.messages.get(f"{part.name}/{port}")
            if name == message.__name__ and newest is not None:
                fields = {key: value for key, value in newest.message.items() if key != "age_s"}
                try:
                    return Report(self, part, msgspec.convert(fields, message), f"{part.name}/{port}", newest.age_s)
                except msgspec.ValidationError:
                    return None
        return None

    def since_s(self, subject: str, kinds: Collection[str]) -> float | None:
        """Return the age of the newest event of these kinds about a subject."""
        return next((self.ago_s(event) for event in self.newest(subject) if event.kind in kinds), None)

    def ago_iso_s(self, text: str) -> float | None:
        """Return the age of a time in the rows; None if it is not a time."""
        with suppress(ValueError):
            return max(0.0, self.wall_ns / 1e9 - datetime.fromisoformat(text).timestamp())
        return None

    def newest(self, subject: str) -> Iterator[Event]:
        """Yield the events of a subject, newest first."""
        return (event for event in reversed(self.events) if event.subject == subject)

    def ago_s(self, event: Event) -> float | None:
        """Return the age of an event, by the wall clock of the robot."""
        return max(0.0, (self.wall_ns - event.wall_ns) / 1e9) if event.wall_ns and self.wall_ns else None


@dataclass(frozen=True, slots=True)
class Report(Generic[State_co]):
    """The newest state of a part, with its topic and age; links are `about` another subject, or else the part."""

    now: Snapshot
    part: Part
    state: State_co
    topic: str
    age_s: float | None
    """None if its clock cannot be compared with ours."""
    about: str = ""

    def link(
        self,
        name: LinkName,
        state: LinkState,
        text: str,
        code: ReasonCode = "",
        *,
        do: str = "",
        about: str = "",
        evidence: str = "",
        since: Collection[str] = (),
        since_s: float | None = None,
    ) -> Link:
        """Return a link with this state as its evidence; `since` are the kinds of events that began it."""
        return Link(
            name,
            about or self.about or self.part.name,
            state,
            text,
            code,
            since_s=self.now.since_s(self.part.name, since) if since else since_s,
            age_s=self.age_s,
            evidence=evidence or self.topic,
            do=do,
        )


def _filled(saying: Saying, wanted: dict[str, object]) -> str:
    """Return the line with these values, empty if the pattern cannot hold them."""
    line, rest = saying.pattern, dict(wanted)
    for name, value in saying.payload.items():
        if name not in rest or rest.pop(name) != value:
            return ""
    for name, value in rest.items():
        if f"{{{name}}}" not in line:
            return ""
        line = line.replace(f"{{{name}}}", ",".join(value) if isinstance(value, list | tuple) else str(value))
    return "" if "{" in line else line
