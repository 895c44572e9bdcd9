"""The chosen part of a robot's recordings, and its messages in order."""

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
"""A round of the box."""
MOST_REPEATED = 50
"""So many events are said again where a file begins, and one message of any stream."""


class Chosen(Struct, frozen=True, kw_only=True):
    """Files that belong together, oldest first: the box, what it kept, a recording, or a file of another."""

    name: str
    files: tuple[Path, ...]
    why: Incident | None = None


class Damage(Struct):
    """The unreadable part: whole files, places in others, and how many bytes these had."""

    files: list[str] = []
    places: int = 0
    bytes: int = 0


def choose(shelf: Shelf, name: str) -> Chosen:
    """Return what is meant by a name: `box` or nothing for the box itself; InputError says what there is."""
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
    """Refuse a file of which nothing can be read: that nothing was recorded in some time is another matter."""
    with reader.opened(path) as found:
        if found.empty:
            text = f"{path}: nothing in it can be read: it is no recording, or was cut short where it begins"
            raise InputError(text, "malformed")


def messages(
    files: Iterable[Path], start_ns: int = 0, end_ns: int = LAST_NS, *, damage: Damage | None = None
) -> Iterator[Message]:
    """Yield the messages of files from one time to another, of each file by their time, and each message once.

    A file begins with what was said last before it; what is damaged is passed over, and counted in `damage`.
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
    """Return the file in which a moment is: the newest that began until then; None if all began later."""
    for path in reversed(list(files)):
        with suppress(InputError), reader.opened(path) as found:
            if found.spans and _begins_ns(found) - BEGINS_NS <= at_ns:
                return path
    return None


def span_ns(files: Iterable[Path]) -> tuple[int, int]:
    """Return when the first message of files was, and the last; zeros without any."""
    first, last = 0, 0
    ordered = list(files)
    for path in ordered:
        try:
            with reader.opened(path) as file:
                if file.spans:
                    begins = _plays_from_ns(file)
                    first = min(first or begins, begins)
                    last = max(last, file.end_ns)
        except InputError:
            continue
    return first, last


def _begins_ns(found: reader.Recording) -> int:
    """Return when a file begins: its first chunk also has what was said last before."""
    return found.spans[1].start_ns if len(found.spans) > 1 else found.spans[0].end_ns


def _plays_from_ns(file: reader.Recording) -> int:
    """Return from when on there is something to play: of a file that was cut after its first chunk, the last round of
    that."""
    only = file.spans[0]
    if len(file.spans) > 1:
        return _begins_ns(file)
    return max(only.start_ns, only.end_ns - BEGINS_NS) if file.about else only.start_ns  # others repeat nothing
