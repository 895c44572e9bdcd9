"""The rows for the rest of the program: checked, frozen, independent of the database."""

from collections.abc import Hashable, Iterator
from collections.abc import Set as AbstractSet
from datetime import datetime
from typing import Annotated, Any, Literal, TypeVar

from msgspec import Meta, Struct, field

from lbr.database import arguments, builtin, patterns
from lbr.database.columns import json_strictly
from lbr.database.reading import Problem, Tables
from lbr.messages import shapes
from lbr.messages.rows import COUNTED, NOW, REQUIRED, Fault, Others, Row, short
from lbr.messages.system import Role, TokenRole
from lbr.messages.units import Name, NameOrNone

R = TypeVar("R", bound=Row)
Restart = Literal["never", "on-failure", "always"]
GoodFor = Literal["bus", "web", "both"]
JsonObject = Annotated[str, Meta(extra={"shape": shapes.OBJECT})]
"""The text of a JSON object, for others to parse."""
End = Annotated[str, Meta(pattern=r"^[a-z][a-z0-9_]{0,39}\.[a-z][a-z0-9_]{0,39}$(?!\n)", extra={"shape": shapes.PORT})]
CapabilityName = Annotated[Name, Meta(extra={"shape": shapes.CAPABILITY_NAME})]
Word = Annotated[str, Meta(pattern="^[A-Za-z][A-Za-z0-9_]{0,39}$(?!\\n)", extra={"shape": shapes.WORD})]
BY_LBR = Meta(extra={"by_lbr": True})
"""For a column that lbr writes while a robot runs: its changes are not edits."""
EXECUTIVE = "executive"
"""The target of verbs and channels that has no row: lbr itself."""
BUILT_IN = "is a word that every robot has, and no row changes: drop this row, or choose another word"


class RobotRow(Row, frozen=True, kw_only=True):
    """The robots. `lbr` runs one of them; its name is the first part of each of its keys on the bus.

    Times are ISO 8601 in UTC. A latch that cannot be read is engaged.
    """

    TABLE = "robot"
    KEY = ("name",)
    SHARED = True

    name: Annotated[Name, "its name in profiles and tables"]
    model: Annotated[str, "the type of robot"] = ""
    description: Annotated[str, "for people"] = ""
    owner: Annotated[str, "for people"] = ""
    last_start: Annotated[str | None, BY_LBR, "its last start"] = None
    last_shutdown: Annotated[str | None, BY_LBR, "its last orderly shutdown"] = None
    estop_engaged: Annotated[
        bool, BY_LBR, Meta(extra={"default": "0"}), "1: the emergency stop is latched, also over restarts"
    ] = True
    estop_reason: Annotated[str, BY_LBR, "the reason of the latch"] = ""


def _not_lbr(row: "CapabilityRow", _: Others) -> Iterator[Fault]:
    if row.name == EXECUTIVE:
        yield "name", "'executive' is lbr itself: choose another name"


def _needs(row: "CapabilityRow", others: Others) -> Iterator[Fault]:
    for needed in row.needs:
        if needed not in others.names("capability"):
            yield "needs", f"there is no capability '{short(needed)}'"


def _needs_of(row: "CapabilityRow") -> Hashable:
    return row.name, row.needs


def _ring(row: "CapabilityRow", others: Others) -> Iterator[Fault]:
    """Find capabilities that need themselves, also through others."""
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
        yield "settings", f"device: there is no device '{short(device)}'"


class CapabilityRow(Row, frozen=True, kw_only=True):
    """The capabilities: one process for each enabled row, unless rows share one."""

    TABLE = "capability"
    KEY = ("name",)
    CHECKS = (_not_lbr, _needs, _ring, _used_device)

    name: Annotated[CapabilityName, "the second part of its keys; `executive` is lbr itself"]
    kind: Annotated[Name, "a registered kind, or a file in $LBR_HOME/capabilities"]
    enabled: Annotated[bool, "whether it is started"] = True
    settings: Annotated[JsonObject, "settings of its kind; unknown keys are refused"] = "{}"
    restart: Annotated[Restart, "when it starts again after its end"] = "on-failure"
    needs: Annotated[tuple[str, ...], "the capabilities that start before it"] = ()
    help: Annotated[str, "for people"] = ""
    process: Annotated[NameOrNone, "the process that it shares; empty: its own"] = ""


def _source(row: "ChannelRow", others: Others) -> Iterator[Fault]:
    yield from _capability_there("source", row.source, others, "")


def _target(row: Any, others: Others) -> Iterator[Fault]:
    yield from _capability_there("target", row.target, others, EXECUTIVE)


def _capability_there(column: str, end: str, others: Others, known: str) -> Iterator[Fault]:
    name, _ = split_end(end)
    if name != known and name not in others.names("capability"):
        yield column, f"there is no capability '{name}'"


class ChannelRow(Row, frozen=True, kw_only=True):
    """The wiring: each row feeds an output to an input."""

    TABLE = "channel"
    KEY = ("source", "target")
    CHECKS = (_source, _target)

    source: Annotated[End, "capability.output"]
    target: Annotated[End, "capability.input"]
    rate_hz: Annotated[float, Meta(gt=0, le=1_000_000), "most messages a second; NULL: all"] | None = None
    history: Annotated[int, Meta(ge=1, le=64), "newest messages that wait for the reader"] = 1
    enabled: Annotated[bool, "whether it is wired"] = True

    @property
    def source_end(self) -> tuple[str, str]:
        """Return the capability and port of its source."""
        return split_end(self.source)

    @property
    def target_end(self) -> tuple[str, str]:
        """Return the capability and port of its target."""
        return split_end(self.target)


def _printable(row: "DeviceRow", _: Others) -> Iterator[Fault]:
    if not row.address.isprintable():
        yield "address", "is not an address (printable, at most 500 characters)"


class DeviceRow(Row, frozen=True, kw_only=True):
    """The devices. A capability's setting `device` names a row of this table."""

    TABLE = "device"
    KEY = ("name",)
    CHECKS = (_printable,)

    name: Annotated[Name, "its name in settings and calibrations"]
    type: Annotated[Name, "its type, which the driver's kind names"]
    address: Annotated[
        str, Meta(min_length=1, max_length=500), "a path, usb:VID:PID[:SERIAL], by-id:GLOB, i2c:BUS:ADDRESS, unix:PATH"
    ]
    settings: Annotated[dict[str, Any], "settings of its type, such as its twin's faults"] = field(default_factory=dict)


def _pattern(row: "VerbRow", _: Others) -> Iterator[Fault]:
    try:
        patterns.parse(row.pattern)
    except ValueError as err:
        yield "pattern", f"'{short(row.pattern)}': {err}"


def _parsed(row: "VerbRow") -> patterns.Pattern | None:
    """Return a verb's pattern; None if it is broken, which `_pattern` reports."""
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
    """Return the form of a verb's lines; empty for a built-in word."""
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
    """The words of the console. A word may have several patterns. `/r/{power}/{angle_deg}` puts parts of a line into
    fields of the target's message, `{text...}` the rest of the line with its slashes. A pattern without a slash is an
    alias."""

    TABLE = "verb"
    KEY = ("word", "pattern")
    CHECKS = (_pattern, _same_word, _bound_twice, _target, _same_lines)

    word: Annotated[Word, "the first part of the pattern; capital letters count"]
    pattern: Annotated[str, Meta(min_length=1, extra={"shape": shapes.PATTERN}), "a line's form, see above"]
    target: Annotated[End, "capability.command, or lbr's own executive.NAME"]
    payload: Annotated[dict[str, Any] | None, "fields that the pattern does not bind"] = None
    role: Annotated[Role, "the least role that may use it"] = "operate"
    help: Annotated[str, "one line for people, with units and bounds"] = ""

    @property
    def target_end(self) -> tuple[str, str]:
        """Return the capability and command that it calls; the capability `executive` is built in."""
        return split_end(self.target)


def _program(row: "ExternalCommandRow", _: Others) -> Iterator[Fault]:
    if not (row.argv and row.argv[0]):
        yield "argv", "names no program"


def _allowed(row: "ExternalCommandRow", _: Others) -> Iterator[Fault]:
    if fault := arguments.fault(row.arguments or ()):
        yield "arguments", fault


def _no_verb(row: "ExternalCommandRow", others: Others) -> Iterator[Fault]:
    if builtin.is_builtin(row.name):
        yield "name", f"'{row.name}' {BUILT_IN}"
    elif (row.name,) in others.index(VerbRow, _line):
        yield "name", f"'{row.name}' is a verb already"


class ExternalCommandRow(Row, frozen=True, kw_only=True):
    """Programs that the console starts by name, without a shell. `arguments` has an entry for each word after the name;
    the last words may be left out. An entry is a list of the allowed words, such as ["left", "right"]. Or it is a
    regular expression for the whole word, such as "[0-9]{1,3}". A word that begins with '-' must be in a list."""

    TABLE = "external_command"
    KEY = ("name",)
    CHECKS = (_program, _allowed, _no_verb)

    name: Annotated[Name, "what to type"]
    argv: Annotated[tuple[str, ...], Meta(extra={"shape": shapes.PROGRAM}), "the program's path, then its arguments"]
    blocking: Annotated[bool, "1: the console waits for its end; 0: it runs on until `stop NAME`"] = False
    enabled: Annotated[bool, "whether it is offered"] = True
    help: Annotated[str, "one line for people"] = ""
    arguments: Annotated[list[Any] | None, "the words after the name, see above"] = None
    role: Annotated[Role, "the least role that may start and end it"] = "operate"


BUILT_IN_VERBS = tuple(
    VerbRow(word=one.word, pattern=one.pattern, target=f"{EXECUTIVE}.{one.target}", role=one.role, help=one.help)
    for one in builtin.WORDS
)
CORE: tuple[type[Row], ...] = (RobotRow, CapabilityRow, ChannelRow, DeviceRow, VerbRow, ExternalCommandRow)
"""The tables of every robot; kinds bring the others."""


class RevisionRow(Struct, frozen=True, kw_only=True):
    """One change of a row, as the triggers kept it."""

    id: int
    table: str
    row_key: tuple[str, ...]
    operation: Literal["insert", "update", "delete"]
    before: dict[str, Any] | None
    after: dict[str, Any] | None
    changed_at: str


class TokenRow(Row, frozen=True, kw_only=True):
    """The roles of people and machines. The token itself is shown once and never stored."""

    TABLE = "user_token"
    KEY = ("name",)
    SHARED = True

    name: Annotated[str, Meta(min_length=1, max_length=40), "its owner"]
    role: Annotated[TokenRole, "look, move, change, or run a share of the robot"]
    hash: Annotated[str, Meta(min_length=32), "of the token"]
    created_at: Annotated[str, NOW, "when"]
    revoked_at: Annotated[str | None, "NULL: valid"] = None
    expires_at: Annotated[str | None, "NULL: never"] = None
    good_for: Annotated[GoodFor, "the doors that it opens"] = "both"
    paired_from: (
        Annotated[str, Meta(min_length=1, max_length=64), "the address that paired; NULL: made by hand"] | None
    ) = None
    called: Annotated[str, Meta(min_length=1, max_length=40), "what people call it; NULL: by its name"] | None = None

    def lets_in(self, door: Literal["bus", "web"]) -> bool:
        """Return whether it is valid for that door."""
        return self.good_for in {"both", door}

    def has_expired(self, now: datetime) -> bool:
        """Return whether it has expired; one with an unreadable end has."""
        if self.expires_at is None:
            return False
        try:
            return not now < datetime.fromisoformat(self.expires_at)
        except (ValueError, TypeError):
            return True


class AuditRow(Row, frozen=True, kw_only=True):
    """The audit trail: what people and programs did to the robot. Each hash covers the hash before it, so `lbr db
    check` finds a changed or missing row. Written by lbr and never changed; the oldest of very many are deleted."""

    TABLE = "audit"
    KEY = ("id",)
    SHARED = True

    id: Annotated[int, COUNTED, "counts up without a gap"] = 0
    wall_ns: Annotated[int, Meta(ge=0), "nanoseconds since 1970 by the wall clock"]
    kind: Annotated[str, "run, shutdown, holder, stopped, estop, login, rows_changed, python ..."]
    subject: Annotated[str, "the capability or person"]
    source: Annotated[str, "the sender, as robot/capability"]
    text: Annotated[str, "one sentence"]
    previous: Annotated[str, REQUIRED, "the hash of the row before; empty for the very first"] = ""
    hash: Annotated[str, REQUIRED, "BLAKE2b over all of this row but itself"] = ""


class Faulty(Struct, frozen=True):
    """A row that is left out, as far as it is readable: its bad `columns` have no meaning."""

    table: str
    label: str
    row: Any
    columns: frozenset[str]


class RobotRows(Struct, frozen=True, kw_only=True):
    """One robot's rows from one transaction: the good ones, and the problems of the others.

    A row with any bad column is left out and named in `problems`; `faulty` has it for further checks of its good
    columns. The rows that kinds read are in `tables`, and checked on request. `revision` counts the changes of rows.
    `digest` is the hash of all rows that make robots.
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

    def names(self, row: type[CapabilityRow | DeviceRow]) -> frozenset[str]:
        """Return the names of a table's rows, including those that are left out."""
        return frozenset(read.name for read, _, _ in self.every(row))

    def every(self, row: type[R]) -> Iterator[tuple[R, str, AbstractSet[str]]]:
        """Yield each row of a table with its label and its bad columns, also those that are left out."""
        good: dict[type[Row], tuple[Any, ...]] = {
            CapabilityRow: self.capabilities,
            ChannelRow: self.channels,
            DeviceRow: self.devices,
            VerbRow: self.verbs,
        }
        for read in good[row]:
            yield read, "/".join((self.robot.name, *read.key)), frozenset()
        for one in self.faulty:
            if one.table == row.TABLE:
                yield one.row, one.label, one.columns


def split_end(end: str) -> tuple[str, str]:
    """Split `capability.port`."""
    capability, _, port = end.partition(".")
    return capability, port
