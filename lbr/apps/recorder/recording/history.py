"""Numbers of streams over time.

For each point one chunk of the box is read, so that a day costs no more than a minute.
"""

from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from msgspec import Struct

from lbr.apps.recorder.recording import reader
from lbr.errors import InputError

NS_PER_MS = 1_000_000


class History(Struct):
    """The times, and each field's value at each of them; None if nothing was published."""

    at_ms: list[int]
    values: dict[str, list[float | None]]


def value_of(message: object, path: Iterable[str]) -> float | None:
    """Return the number at a path in decoded JSON, or None."""
    for part in path:
        if isinstance(message, dict):
            message = message.get(part)
        elif isinstance(message, list) and part.isdigit() and int(part) < len(message):
            message = message[int(part)]
        else:
            return None
    return float(message) if isinstance(message, bool | int | float) else None


def history(files: Iterable[Path], fields: Iterable[str], start_ns: int, end_ns: int, points: int) -> History:
    """Return fields such as `battery/state.voltage_v` between two times, in `points` points at most."""
    sampled = History([], {field: [] for field in fields})
    wanted: dict[str, list[str]] = {}
    for field in sampled.values:
        wanted.setdefault(field.partition(".")[0], []).append(field)
    step_ns = max(1, (end_ns - start_ns) // points)
    due_ns = start_ns
    for path in files:
        with suppress(InputError, OSError):
            if path.stat().st_mtime_ns < due_ns:
                continue
            with reader.opened(path) as file:
                due_ns = _sample(file, sampled, wanted, due_ns, end_ns, step_ns)
        if due_ns > end_ns:
            break
    return sampled


def _sample(
    file: reader.Recording, sampled: History, wanted: dict[str, list[str]], due_ns: int, end_ns: int, step_ns: int
) -> int:
    """Add the points of a file from `due_ns` on; return when the next point is due."""
    for span, messages in file.chunks():
        if due_ns <= span.end_ns <= end_ns:
            newest = {sample.topic: sample for sample in messages() if sample.topic in wanted}
            sampled.at_ms.append(span.end_ns // NS_PER_MS)
            for topic, fields in wanted.items():
                message = newest[topic].read(object) if topic in newest else None
                for field in fields:
                    sampled.values[field].append(value_of(message, field.partition(".")[2].split(".")))
            due_ns = span.end_ns + step_ns
    return due_ns
