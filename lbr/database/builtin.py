"""The words that every robot understands, whatever its rows: to stop, to ask, and to end. No row replaces them."""

from typing import NamedTuple

from lbr.database.patterns import Pattern
from lbr.messages.system import Role


class Word(NamedTuple):
    """A line, the command of lbr that it calls, its least role, and its help."""

    pattern: str
    target: str
    role: Role
    help: str

    @property
    def word(self) -> str:
        """Return its first word."""
        return self.pattern.strip("/").partition("/")[0]


_STOP = "Stop whatever moves; anyone may"

WORDS: tuple[Word, ...] = (
    Word("s", "stop", "view", _STOP),
    Word("S", "stop", "view", _STOP),
    Word("stop", "stop", "view", f"{_STOP}. With a name: end that external command"),
    Word("estop", "estop", "view", "Emergency stop: all stops and stays so until reset; anyone may"),
    Word("/estop/{reason...}", "estop", "view", "Emergency stop, and why"),
    Word("reset", "reset", "operate", "Release the emergency stop; nothing moves by that alone"),
    Word("status", "status", "view", "Show what runs and how it is"),
    Word("help", "help", "view", "List the words of this robot. With a word: its fields, such as `help r`"),
    Word("/help/{word}", "help", "view", "Show the fields of a word"),
    Word("Shutdown", "shutdown", "admin", "Stop everything in order and end; mind the capital letter"),
)

_TAKEN = frozenset(row.word.lower() for row in WORDS)
_WITH_PARTS = frozenset(row.word.lower() for row in WORDS if row.pattern.startswith("/"))


def is_builtin(word: str) -> bool:
    """Return whether a bare word is built in, whatever its case."""
    return word.lower() in _TAKEN


def shadowed(pattern: Pattern) -> bool:
    """Return whether a pattern would catch a built-in line: `/stop` means the same as `stop`."""
    return is_builtin(pattern.word) if not pattern.parts else pattern.word.lower() in _WITH_PARTS
