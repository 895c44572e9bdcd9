"""The comparison of two runs of a robot: numbers over time, and events. Pure; times in ns of the recording."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

WINDOW_NS = 300_000_000
"""The greatest distance in time of equal values: twice a tick of each operation on the way and a servo bus sweep."""
TOLERANCE = 0.1
"""The tolerance, as a share of a number's span in the recording. Feedback comes up to a tick earlier or later than
recorded. That may change the last creeping steps of a turn, and nothing larger."""
SMALLEST = 0.02
"""The least tolerance: a step of the coarsest servo's encoder in rad, and a fiftieth of full power."""
UNTOLD = frozenset({"id", "lease", "halt", "count", "seq", "time_s", "stamp_s"})
"""Fields that count or name, and so differ in every run."""

Series = Sequence[tuple[int, Mapping[str, float]]]


class Difference(NamedTuple):
    """A number that differs between two runs; NaN: missing at that time."""

    at_ns: int
    field: str
    recorded: float
    now: float


class CodedEvent(NamedTuple):
    """An event: its time, subject, kind and code."""

    at_ns: int
    subject: str
    kind: str
    code: str

    @property
    def identity(self) -> tuple[str, str, str]:
        """All but the time."""
        return self.subject, self.kind, self.code


def numbers(message: object, path: str = "") -> dict[str, float]:
    """Return the numbers of a message by their paths; counters and names are left out."""
    if isinstance(message, bool | int | float):
        return {path: float(message)}
    values: dict[str, float] = {}
    if isinstance(message, Mapping):
        for key, value in message.items():
            if key not in UNTOLD:
                values |= numbers(value, f"{path}.{key}" if path else str(key))
    elif isinstance(message, Sequence) and not isinstance(message, str):
        for place, value in enumerate(message):
            values |= numbers(value, f"{path}.{_name_of(value, place)}" if path else _name_of(value, place))
    return values


def differences(recorded: Series, now: Series, window_ns: int = WINDOW_NS) -> list[Difference]:
    """Return the numbers of each run that the other lacks at about that time; both runs are in order of time."""
    fields = {name for _, values in (*recorded, *now) for name in values}
    diffs = []
    for name in sorted(fields):
        ours = [(at, values[name]) for at, values in recorded if name in values]
        theirs = [(at, values[name]) for at, values in now if name in values]
        span = [value for _, value in ours if math.isfinite(value)] or [0.0]
        tolerance = max(SMALLEST, TOLERANCE * (max(span) - min(span)))
        diffs += [Difference(at, name, value, other) for at, value, other in _unmet(ours, theirs, window_ns, tolerance)]
        diffs += [Difference(at, name, other, value) for at, value, other in _unmet(theirs, ours, window_ns, tolerance)]
    return sorted(diffs)


def unmatched(
    recorded: Iterable[CodedEvent], now: Iterable[CodedEvent], window_ns: int
) -> tuple[list[CodedEvent], list[CodedEvent]]:
    """Return the events of only one run: of the recorded one, and of this one."""
    remaining = sorted(now)
    alone = []
    for event in sorted(recorded):
        match = min(
            (
                candidate
                for candidate in remaining
                if candidate.identity == event.identity and abs(candidate.at_ns - event.at_ns) <= window_ns
            ),
            key=lambda candidate: abs(candidate.at_ns - event.at_ns),
            default=None,
        )
        if match is None:
            alone.append(event)
        else:
            remaining.remove(match)
    return alone, remaining


def _unmet(
    ours: list[tuple[int, float]], theirs: list[tuple[int, float]], window_ns: int, tolerance: float
) -> Iterable[tuple[int, float, float]]:
    """Yield each of our values without a similar one of theirs within the window, and their nearest."""
    first = last = 0
    for at, value in ours:
        while first < len(theirs) and theirs[first][0] < at - window_ns:
            first += 1
        while last < len(theirs) and theirs[last][0] <= at + window_ns:
            last += 1
        near = [each for _, each in theirs[first:last]]
        if not near:
            yield at, value, math.nan
        elif not min(near) - tolerance <= value <= max(near) + tolerance:
            yield at, value, min(near, key=lambda each: abs(each - value))


def _name_of(value: object, place: int) -> str:
    if isinstance(value, Mapping):
        return str(value.get("name", value.get("id", place)))
    return str(place)
