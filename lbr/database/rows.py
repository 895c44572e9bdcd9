"""The rows as the rest of the program sees them: checked, frozen, free of the database they came from."""

from collections.abc import Hashable, Iterator
from datetime import datetime
from typing import Annotated, Any, Literal, TypeVar

from msgspec import Meta, Struct, field

from lbr.database import arguments, builtin, patterns
from lbr.database.columns import json_strictly
from lbr.database.reading import Problem, Tables
from lbr.messages.rows import Fault, Others, Row, shown
from lbr.messages.system import Role, TokenRole
from lbr.messages.units import Name, NameOrNone

R = TypeVar("R", bound=Row)
Restart = Literal["never", "on-failure", "always"]
GoodFor = Literal["bus", "web", "both"]
JsonObject = Annotated[str, Meta(extra={"json": "object"})]
"""The text of a JSON object, for others to parse."""
End = Annotated[
    str,
    Meta(pattern=r"^[a-z][a-z0-9_]{0,39}\.[a-z][a-z0-9_]{0,39}$(?!\n)", extra={"meant": "of the form capability.port"}),
]
EXECUTIVE = "executive"
"""What verbs and channels may have as their target without a row of its own: lbr itself."""
BUILT_IN = "is a word that every robot has, and no row changes: drop this row, or choose another word"


class RobotRow(Row, frozen=True, kw_only=True):
    """The robot itself; times are ISO 8601 in UTC. A latch that cannot be read is engaged."""

    TABLE = "robot"
    KEY = ("name",)

    name: Name
    model: str = ""
    description: str = ""
    owner: str = ""
    last_start: str | None = None
    last_shutdown: str | None = None
    estop_engaged: bool = True
    estop_reason: str = ""


def _not_lbr(row: "CapabilityRow", _: Others) -> Iterator[Fault]:
    if row.name == EXECUTIVE:
        yield "name", "'executive' is lbr itself: choose another name"


def _needs(row: "CapabilityRow", others: Others) -> Iterator[Fault]:
    for needed in row.needs:
        if needed not in others.names("capability"):
            yield "needs", f"there is no capability '{shown(needed)}'"


def _needs_of(row: "CapabilityRow") -> Hashable:
    return row.name, row.needs


def _ring(row: "CapabilityRow", others: Others) -> Iterator[Fault]:
    """Find what needs itself, if only by way of others."""
    rows = others.index(CapabilityRow, _needs_of)
    known = {one.name: one.needs for one in rows.values()}
    seen: set[str] = set()
    ahead = list(row.needs)
    while ahead:
        needed = ahead.pop()
        if needed not in seen:
            seen.add(needed)
            ahead.extend(known.get(needed, ()))
    if row.name in seen:
        yield "needs", "it needs itself, by way of what it needs"


def _used_device(row: "CapabilityRow", others: Others) -> Iterator[Fault]:
    device = json_strictly(row.settings).get("device")
    if isinstance(device, str) and device not in others.names("device"):
        yield "settings", f"device: there is no device '{shown(device)}'"


class CapabilityRow(Row, frozen=True, kw_only=True):
    """One capability to run: `settings` is for the kind to parse; `needs` start before it; `process` is one that it
    shares."""

    TABLE = "capability"
    KEY = ("name",)
    CHECKS = (_not_lbr, _needs, _ring, _used_device)

    name: Name
    kind: Name
    enabled: bool = True
    settings: JsonObject = "{}"
    restart: Restart = "on-failure"
    needs: tuple[str, ...] = ()
    process: NameOrNone = ""
    help: str = ""


def _source(row: "ChannelRow", others: Others) -> Iterator[Fault]:
    yield from _capability_there("source", row.source, others, "")


def _target(row: Any, others: Others) -> Iterator[Fault]:
    yield from _capability_there("target", row.target, others, EXECUTIVE)


def _capability_there(column: str, end: str, others: Others, known: str) -> Iterator[Fault]:
    name, _ = split_end(end)
    if name != known and name not in others.names("capability"):
        yield column, f"there is no capability '{name}'"


class ChannelRow(Row, frozen=True, kw_only=True):
    """A wire from an output to an input, both `capability.port`; at most `rate_hz` (None: every one)."""

    TABLE = "channel"
    KEY = ("source", "target")
    CHECKS = (_source, _target)

    source: End
    target: End
    rate_hz: Annotated[float, Meta(gt=0, le=1_000_000)] | None = None
    history: Annotated[int, Meta(ge=1, le=64)] = 1
    enabled: bool = True

    @property
    def source_end(self) -> tuple[str, str]:
        """Capability and port it comes from."""
        return split_end(self.source)

    @property
    def target_end(self) -> tuple[str, str]:
        """Capability and port it goes to."""
        return split_end(self.target)


def _printable(row: "DeviceRow", _: Others) -> Iterator[Fault]:
    if not row.address.isprintable():
        yield "address", "is not an address (printable, at most 500 characters)"


class DeviceRow(Row, frozen=True, kw_only=True):
    """What is plugged in, and where."""

    TABLE = "device"
    KEY = ("name",)
    CHECKS = (_printable,)

    name: Name
    type: Name
    address: Annotated[str, Meta(min_length=1, max_length=500)]
    settings: dict[str, Any] = field(default_factory=dict)


def _pattern(row: "VerbRow", _: Others) -> Iterator[Fault]:
    try:
        patterns.parse(row.pattern)
    except ValueError as err:
        yield "pattern", f"'{shown(row.pattern)}': {err}"


def _parsed(row: "VerbRow") -> patterns.Pattern | None:
    """Return a verb's pattern; None if it is none, which is told by `_pattern`."""
    try:
        return patterns.parse(row.pattern)
    except ValueError:
        return None


def _same_word(row: "VerbRow", _: Others) -> Iterator[Fault]:
    pattern = _parsed(row)
    if pattern is not None and row.word != pattern.word:
        yield "pattern", f"begins with '{pattern.word}', but the word of this row is '{row.word}'"


def _bound_twice(row: "VerbRow", _: Others) -> Iterator[Fault]:
    pattern = _parsed(row)
    for bound in pattern.fields if pattern is not None else ():
        if bound in (row.payload or {}):
            yield "payload", f"sets '{bound}', which the pattern binds: leave it out of one of them"


def _line(row: "VerbRow") -> Hashable:
    """Return the lines that a verb takes; empty for a word that is built in."""
    pattern = _parsed(row)
    return () if pattern is None or builtin.shadowed(pattern) or pattern.word != row.word else pattern.shape


def _same_lines(row: "VerbRow", others: Others) -> Iterator[Fault]:
    pattern = _parsed(row)
    if pattern is not None and pattern.word == row.word and builtin.shadowed(pattern):
        yield "word", f"'{row.word}' {BUILT_IN}"
    first = others.index(VerbRow, _line)[_line(row)] if _line(row) else row
    if first.key != row.key:
        yield "pattern", f"takes the same lines as '{first.pattern}'"


class VerbRow(Row, frozen=True, kw_only=True):
    """One console line: `pattern` binds path fields to the target's message, `payload` fixes the others."""

    TABLE = "verb"
    KEY = ("word", "pattern")
    CHECKS = (_pattern, _same_word, _bound_twice, _target, _same_lines)

    word: Annotated[
        str,
        Meta(
            pattern="^[A-Za-z][A-Za-z0-9_]{0,39}$(?!\\n)",
            extra={"meant": "a word (letters, digits, underscores; at most 40)"},
        ),
    ]
    pattern: Annotated[str, Meta(min_length=1)]
    target: End
    role: Role
    help: str
    payload: dict[str, Any] | None = None

    @property
    def target_end(self) -> tuple[str, str]:
        """Capability and command it asks; the capability `executive` is built in."""
        return split_end(self.target)


def _program(row: "ExternalCommandRow", _: Others) -> Iterator[Fault]:
    if not (row.argv and row.argv[0]):
        yield "argv", "names no program"


def _allowed(row: "ExternalCommandRow", _: Others) -> Iterator[Fault]:
    if fault := arguments.fault(row.arguments or ()):
        yield "arguments", fault


def _no_verb(row: "ExternalCommandRow", others: Others) -> Iterator[Fault]:
    if builtin.taken(row.name):
        yield "name", f"'{row.name}' {BUILT_IN}"
    elif (row.name,) in others.index(VerbRow, _line):
        yield "name", f"'{row.name}' is a verb already"


class ExternalCommandRow(Row, frozen=True, kw_only=True):
    """A program started by name, without a shell.

    `arguments` says for each argument that may be typed after the name which words it may be, or the regular
    expression that all of it must fit.
    """

    TABLE = "external_command"
    KEY = ("name",)
    CHECKS = (_program, _allowed, _no_verb)

    name: Name
    argv: tuple[str, ...]
    blocking: bool = False
    enabled: bool = True
    help: str = ""
    arguments: list[Any] | None = None
    role: Role = "operate"


BUILT_IN_VERBS = tuple(
    VerbRow(word=one.word, pattern=one.pattern, target=f"{EXECUTIVE}.{one.target}", role=one.role, help=one.help)
    for one in builtin.WORDS
)
CORE: tuple[type[Row], ...] = (RobotRow, CapabilityRow, ChannelRow, DeviceRow, VerbRow, ExternalCommandRow)
"""What every robot has; kinds bring the others."""


class RevisionRow(Struct, frozen=True, kw_only=True):
    """One change of a row, as the triggers kept it."""

    id: int
    table: str
    row_key: tuple[str, ...]
    operation: Literal["insert", "update", "delete"]
    old: dict[str, Any] | None
    new: dict[str, Any] | None
    changed_at: str


class TokenRow(Struct, frozen=True, kw_only=True):
    """A user's rights: `hash` is of the token; times are ISO 8601 in UTC, None for never.

    `paired_from` is the address of the device that was given it for a code, None if it was made by hand.
    """

    name: str
    role: TokenRole
    hash: str
    created_at: str
    revoked_at: str | None = None
    expires_at: str | None = None
    good_for: GoodFor = "both"
    paired_from: str | None = None

    def lets_in(self, door: Literal["bus", "web"]) -> bool:
        """Say whether it is one for that way in."""
        return self.good_for in {"both", door}

    def has_expired(self, now: datetime) -> bool:
        """Say whether its time is over; one whose end cannot be read is over."""
        if self.expires_at is None:
            return False
        try:
            return not now < datetime.fromisoformat(self.expires_at)
        except (ValueError, TypeError):
            return True


class AuditRow(Struct, frozen=True, kw_only=True):
    """One entry of the audit trail; number and hashes are given when it is written."""

    wall_ns: int
    kind: str
    subject: str
    source: str
    text: str
    id: int = 0
    previous: str = ""
    hash: str = ""


class Faulty(Struct, frozen=True):
    """A row that is left out, as far as it can be read: what stands in its bad `columns` says nothing."""

    table: str
    label: str
    row: Any
    columns: frozenset[str]


class RobotRows(Struct, frozen=True, kw_only=True):
    """One robot's rows out of one transaction: the good ones, and what is wrong with the others.

    Rows of which any column is bad are left out and named in `problems`; they are in `faulty` for further checks of
    what is good in them. What kinds read is in `tables`, and checked when it is asked for. `revision` counts the
    changes of rows, `digest` is the hash of all rows that make robots.
    """

    robot: RobotRow
    capabilities: tuple[CapabilityRow, ...] = ()
    channels: tuple[ChannelRow, ...] = ()
    devices: tuple[DeviceRow, ...] = ()
    verbs: tuple[VerbRow, ...] = ()
    external_commands: tuple[ExternalCommandRow, ...] = ()
    tables: Tables = Tables({}, "", {})
    tokens: tuple[TokenRow, ...] = ()
    revision: int = 0
    digest: str = ""
    problems: tuple[Problem, ...] = ()
    faulty: tuple[Faulty, ...] = ()

    def of(self, row: type[R]) -> tuple[R, ...]:
        """Return the good rows of a table."""
        return self.tables.good(row)

    def names(self, table: Literal["capability", "device"]) -> frozenset[str]:
        """Return the names of a table's rows, those that are left out too."""
        rows = self.capabilities if table == "capability" else self.devices
        return frozenset(row.name for row in rows) | {one.row.name for one in self.faulty if one.table == table}


def split_end(end: str) -> tuple[str, str]:
    """Split `capability.port`."""
    capability, _, port = end.partition(".")
    return capability, port
