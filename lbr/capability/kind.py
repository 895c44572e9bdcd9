"""Kinds, which capability rows name. Declared once per driver, operation or app; light to import."""

import contextlib
import importlib.util
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, Protocol, TypeVar

import msgspec
from msgspec import Struct

from lbr import plugins
from lbr.capability import leaving
from lbr.capability.border import border
from lbr.capability.settings import decoded
from lbr.capability.word import Word
from lbr.errors import LbrError
from lbr.messages.camera import JpegFrame
from lbr.messages.rows import Row
from lbr.messages.schema import JsonObject
from lbr.messages.system import Role

STOP = "stop"
Family = Literal["driver", "operation", "app", "simulation", "program"]
Emulation = Literal["tty", "socket", "folder"]
Line = Literal["", "serial", "polled"]
R = TypeVar("R", bound=Row)


class KindError(LbrError):
    """A kind that does not exist or cannot be loaded; the text has the reason and the alternatives."""


class LackingError(KindError):
    """A kind that is missing, where an unusable component may have it."""


class NoSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """The settings of a kind that has none."""


@dataclass(frozen=True, slots=True)
class Rows:
    """The rows of a table that a kind reads: all of the robot's, or those `where` a column equals a setting.

    An empty column matches every setting. An empty setting matches every column. `learnt` rows may be written back.
    Edits of `followed` rows come while it runs; for those of others it is restarted.
    """

    row: type[Row]
    where: Mapping[str, str] = field(default_factory=dict)
    learnt: bool = False
    followed: bool = False


@dataclass(frozen=True, slots=True)
class OnDevice:
    """The device that a kind owns: its setting `device` names a device row of this `type`.

    `line` marks a serial line, whose address may be `usb:VID:PID` or `by-id:GLOB`. `polled` lines carry many questions
    a second, so the latency of an adapter matters. `emulated` is its form in a simulation: a tty, a socket
    (`unix:PATH`) or a folder. `recognised` names its handshakes for `lbr devices`, `module:HANDSHAKES` (see
    `lbr.capability.recognition`).
    """

    type: str
    line: Line = ""
    emulated: Emulation = "tty"
    recognised: str = ""


@dataclass(frozen=True, slots=True)
class Rights:
    """The rights of a kind beyond its wires.

    `serves`: people move and stop the robot through it, so it ranks with the movers. `people`: it may receive every
    stream, request every command and send console lines of each role. It is responsible for its users. `pairs`: it
    gives tokens to phones. Its request `pair` sends the executive the digits that a person read at the console. The
    words `open` and `close` change its setting `host`. `lets_in`: its settings, or `enabled`, that decide about access.
    No page changes them. `records`: it may receive every stream, event and status, and read the robot's description. It
    runs when all others leave it time. `emulates`: a world that gets every device with a twin (see
    `lbr.capability.twins`). `edits`: the tables whose rows it may edit by `executive.edit`, if wired to that.
    """

    serves: bool = False
    people: bool = False
    pairs: bool = False
    lets_in: tuple[str, ...] = ()
    records: bool = False
    emulates: bool = False
    edits: tuple[type[Row], ...] = ()


@dataclass(frozen=True, slots=True)
class Needs:
    """The package that a kind requires, and the extra of lbr that installs it."""

    package: str
    extra: str


@dataclass(frozen=True, slots=True)
class Wire:
    """The default wire of a port that no row wires: each port `to` of the same type that a capability of the robot has.

    `to` is the port's name, or `kind.port`; `history` is a channel's.
    """

    to: str
    history: int = 1


class Known(Protocol):
    """The source of a field's values in a command: the robot's files, its rows, or the wires of a capability."""

    home: Path
    devices: tuple[str, ...]
    wired: tuple[str, ...]

    def rows(self, row: type[R]) -> tuple[R, ...]:
        """Return the rows of a table."""


Choices = Callable[[Known], Iterable[str]]


@dataclass(frozen=True, slots=True)
class Command:
    """A command and its properties besides its message.

    A `leased` command is held: its sender repeats it under its lease. `choices` are the values of its fields on this
    robot, for completion. `role` is the least role of a sender on another machine.
    """

    message: type[Struct]
    leased: bool = False
    role: Role = "operate"
    choices: Mapping[str, Choices] = field(default_factory=dict)


def names(row: type[Row], column: str = "name") -> Choices:
    """Return choices from a column of rows."""
    return lambda known: {getattr(one, column) for one in known.rows(row)}


@dataclass(frozen=True, kw_only=True, slots=True)
class Kind:
    """One kind of driver, operation or app: its settings, its ports and the place of its code.

    `entry` names the class that runs (`module:Class`), imported only in its own process, or is that class. `inputs` are
    streams it reads. `setpoints` are streams sent to its own key, which only the wired source may write. `outputs` are
    streams it publishes, `commands` those that it answers, `requests` those that it sends to others. A command without
    a type in `replies` is answered by a CommandReply. `optional` are the inputs that it can do without: they may be
    unfed. `wires` are the inputs and requests that need no channel row. `words` are added to the console of every robot
    with a capability of this kind. `says` names its setting with console lines, each of which its robot must know.
    `moves` marks a path to a motor. Such a kind gets the emergency stop on a session of its own. It is stopped first.
    `rows` are the tables whose rows it gets.
    """

    name: str
    summary: str
    family: Family
    entry: str | type
    settings: type[Struct] = NoSettings
    inputs: Mapping[str, type[Struct]] = field(default_factory=dict)
    setpoints: Mapping[str, type[Struct]] = field(default_factory=dict)
    outputs: Mapping[str, type[Struct]] = field(default_factory=dict)
    commands: Mapping[str, type[Struct] | Command] = field(default_factory=dict)
    replies: Mapping[str, type[Struct]] = field(default_factory=dict)
    requests: Mapping[str, type[Struct]] = field(default_factory=dict)
    optional: Collection[str] = ()
    wires: Mapping[str, Wire] = field(default_factory=dict)
    words: tuple[Word, ...] = ()
    says: str = ""
    moves: bool = False
    device: OnDevice | None = None
    rows: tuple[type[Row] | Rows, ...] = ()
    rights: Rights = Rights()
    needs: Needs | None = None

    @property
    def messages(self) -> dict[str, type[Struct]]:
        """Return the message type of each command."""
        return {name: self.command(name).message for name in self.commands}

    @property
    def device_type(self) -> str:
        """Return the type of its device row; empty without a device."""
        return self.device.type if self.device is not None else ""

    @property
    def reads(self) -> tuple[Rows, ...]:
        """Return the tables whose rows it gets."""
        return tuple(one if isinstance(one, Rows) else Rows(one) for one in self.rows)

    @property
    def learns(self) -> tuple[type[Row], ...]:
        """Return the tables whose rows it may write back."""
        return tuple(one.row for one in self.reads if one.learnt)

    def command(self, name: str) -> Command:
        """Return a command with its properties."""
        found = self.commands[name]
        return found if isinstance(found, Command) else Command(found)

    def role(self, command: str) -> Role:
        """Return the least role that a command needs of a sender on another machine. Anybody may stop."""
        return "view" if command == STOP else self.command(command).role

    def schema(self, name: str, message: type[Struct]) -> JsonObject:
        """Return the JSON Schema of a message; for a command, with the least role of a sender on another machine."""
        if message is JpegFrame:
            return {"title": message.__name__, "description": message.__doc__, "contentMediaType": "image/jpeg"}
        found = msgspec.json.schema(message)
        return found | {"x-role": self.role(name)} if name in self.commands else found

    def lacks(self) -> str:
        """Return what must be installed before it can run, and how; empty if nothing is missing."""
        if self.needs is None:
            return ""
        with contextlib.suppress(ImportError, ValueError):
            if importlib.util.find_spec(self.needs.package) is not None:
                return ""
        return f"'{self.needs.package}' is not installed: pip install 'lbr[{self.needs.extra}]'"

    def parse(self, settings: str | bytes) -> Struct:
        """Return the settings of a row, checked; raise msgspec.MsgspecError naming the field."""
        parsed: Struct = decoded(settings, self.settings)
        return parsed

    def load(self) -> type:
        """Import and return the class that runs; raise KindError with the kind, its entry, and the faulty line."""
        if isinstance(self.entry, type):
            return self.entry
        entry = f"kind '{self.name}': its entry {self.entry}"
        with border(lambda err: KindError(f"{entry} does not load: {leaving.text(err)}")):
            loaded = plugins.load(self.entry)
        if not isinstance(loaded, type):
            raise KindError(f"{entry} is not a class")
        return loaded
