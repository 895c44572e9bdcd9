"""The words that every robot understands, whatever its rows say: to stop, to ask, and to end. No row takes one away."""

from lbr.database.patterns import Pattern
from lbr.database.rows import VerbRow
from lbr.messages.system import Role


def _word(pattern: str, target: str, role: Role, text: str) -> VerbRow:
    word = pattern.strip("/").partition("/")[0]
    return VerbRow(word=word, pattern=pattern, target=f"executive.{target}", role=role, help=text)


_STOP = "Stop whatever moves; anyone may"

WORDS: tuple[VerbRow, ...] = (
    _word("s", "stop", "view", _STOP),
    _word("S", "stop", "view", _STOP),
    _word("stop", "stop", "view", f"{_STOP}. With a name: end that external command"),
    _word("estop", "estop", "view", "Emergency stop: all stops and stays so until reset; anyone may"),
    _word("/estop/{reason...}", "estop", "view", "Emergency stop, and why"),
    _word("reset", "reset", "operate", "Release the emergency stop; nothing moves by that alone"),
    _word("status", "status", "view", "Show what runs and how it is"),
    _word("help", "help", "view", "List what can be said here"),
    _word("Shutdown", "shutdown", "admin", "Stop everything in order and end; mind the capital letter"),
)

_TAKEN = frozenset(row.word.lower() for row in WORDS)
_WITH_PARTS = frozenset(row.word.lower() for row in WORDS if row.pattern.startswith("/"))


def taken(word: str) -> bool:
    """Say whether a bare word is one of them, in capital letters or small ones."""
    return word.lower() in _TAKEN


def shadowed(pattern: Pattern) -> bool:
    """Say whether a pattern would take a line that is theirs: `/stop` says what `stop` does."""
    return taken(pattern.word) if not pattern.parts else pattern.word.lower() in _WITH_PARTS
