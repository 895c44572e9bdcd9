"""The chosen files among a robot's recordings, and their messages in order."""

from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

from msgspec import Struct

from lbr.apps.recorder.recording import reader
from lbr.apps.recorder.recording.chunks import Message
from lbr.apps.recorder.recording.shelf import SUFFIX, Incident, Shelf
from lbr.errors import InputError

BOX = "box"
LAST_NS = 1 << 63
EVENT = "@event"
BEGINS_NS = 1_000_000_000
"""A round of the box, about."""
MOST_REPEATED = 50
"""The events that a new file repeats; of any stream it repeats one message."""


class Damage(Struct):
    """The unreadable part: whole files, and the places and bytes in others."""

    files: list[str] = []
    places: int = 0
    bytes: int = 0


class Chosen(Struct, frozen=True, kw_only=True):
    """A span of time of files that belong together, oldest first: the box, a kept incident, a recording, or any other
    file."""

    name: str
    files: tuple[Path, ...]
    why: Incident | None = None
    start_ns: int = 0
    end_ns: int = LAST_NS

    def messages(self, damage: Damage | None = None) -> Iterator[Message]:
        """Yield its messages, as the function `messages` does."""
        return messages(self.files, self.start_ns, self.end_ns, damage=damage)


def choose(shelf: Shelf, name: str) -> Chosen:
    """Return the recording of a name, `box` or nothing for the box itself; raise InputError with the choices."""
    if name in {"", BOX}:
        return Chosen(name=BOX, files=tuple(shelf.files()))
    for incident in shelf.incidents():
        if name == incident.path.name:
            return Chosen(name=name, files=incident.files, why=incident.why)
    for path in shelf.recordings():
        if name in {path.name, path.stem}:
            return Chosen(name=path.name, files=(path,))
    path = Path(name)
    if path.is_file():
        _refuse_empty(path)
        return Chosen(name=path.name, files=(path,))
    if path.is_dir() and (files := sorted(path.glob(f"*{SUFFIX}"))):
        return Chosen(name=path.name, files=tuple(files))
    there = [BOX, *(one.path.name for one in shelf.incidents()), *(one.stem for one in shelf.recordings())]
    raise InputError(
        f"there is no recording '{name[:80]}'; there is {', '.join(there)}, or name a file", "unknown_name"
    )


def _refuse_empty(path: Path) -> None:
    """Refuse a file without a readable record, which is not the same as a time without messages."""
    with reader.opened(path) as found:
        if found.empty:
            text = f"{path}: nothing in it can be read: it is no recording, or was cut short where it begins"
            raise InputError(text, "malformed")


def messages(
    files: Iterable[Path], start_ns: int = 0, end_ns: int = LAST_NS, *, damage: Damage | None = None
) -> Iterator[Message]:
    """Yield the messages of a time span file by file, in order of time, each once.

    A file begins with repeated older messages. Damaged parts are skipped, and counted in `damage`.
    """
    seen: dict[str, deque[tuple[int, int]]] = {}
    for path in files:
        try:
            with reader.opened(path) as file:
                if file.spans and (file.end_ns < start_ns or _begins_ns(file) > end_ns):
                    continue
                ordered = sorted(file.messages(start_ns, end_ns), key=lambda message: message.log_ns)
                if damage is not None and file.damage.places:
                    damage.places += file.damage.places
                    damage.bytes += file.damage.bytes
        except InputError as err:
            if damage is not None:
                damage.files.append(str(err))
            continue
        for message in ordered:
            mark = message.sequence, message.publish_ns
            known = seen.setdefault(message.topic, deque(maxlen=MOST_REPEATED if message.topic == EVENT else 1))
            if message.sequence and mark in known:
                continue
            known.append(mark)
            yield message


def file_at(files: Iterable[Path], at_ns: int) -> Path | None:
    """Return the file that holds a moment: the newest that began before it, or None."""
    for path in reversed(list(files)):
        with suppress(InputError), reader.opened(path) as found:
            if found.spans and _begins_ns(found) - BEGINS_NS <= at_ns:
                return path
    return None


def span_ns(files: Iterable[Path]) -> tuple[int, int]:
    """Return the times of the first and last message in files; zeros without messages."""
    first, last = 0, 0
    for path in files:
        with suppress(InputError), reader.opened(path) as file:
            if file.spans:
                begins = _plays_from_ns(file)
                first, last = min(first or begins, begins), max(last, file.end_ns)
    return first, last


def _begins_ns(found: reader.Recording) -> int:
    """Return when a file begins; its first chunk also repeats older messages."""
    return found.spans[1].start_ns if len(found.spans) > 1 else found.spans[0].end_ns


def _plays_from_ns(file: reader.Recording) -> int:
    """Return the time of the first message to play; in a file of one chunk, that of its last round."""
    only = file.spans[0]
    if len(file.spans) > 1:
        return _begins_ns(file)
    return max(only.start_ns, only.end_ns - BEGINS_NS) if file.about else only.start_ns  # others repeat nothing
