"""The columns that a table may have: names of the robot's telemetry, and of the run itself. Pure."""

import types
from collections.abc import Callable, Iterator, Mapping
from functools import cache, lru_cache
from math import isnan
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

import msgspec
from msgspec import Struct

from lbr.apps.behaviours.cells import CellError, Value
from lbr.messages.attitude import AttitudeState
from lbr.messages.battery import BatteryState
from lbr.messages.beacon import BeaconState
from lbr.messages.codes import MEANINGS
from lbr.messages.dock import DockSignal
from lbr.messages.drive import DriveState
from lbr.messages.joints import JointsState, MotionsState
from lbr.messages.motors import MotorsState
from lbr.messages.odometry import OdometryState
from lbr.messages.power import PowerState
from lbr.messages.sensing import Ranges
from lbr.messages.sighting import SightingState
from lbr.messages.speech import SpeechState
from lbr.messages.tracking import TrackingState
from lbr.names import near

STREAMS: Mapping[str, type[Struct]] = {
    "ranges": Ranges,
    "attitude": AttitudeState,
    "battery": BatteryState,
    "motors": MotorsState,
    "drive": DriveState,
    "dock": DockSignal,
    "beacon": BeaconState,
    "odometry": OdometryState,
    "speech": SpeechState,
    "sighting": SightingState,
    "tracking": TrackingState,
    "joints": JointsState,
    "motions": MotionsState,
    "power": PowerState,
}
"""The telemetry: the message type of each input."""
NEWEST_S: Mapping[str, float] = {
    "battery": 3.0,
    "dock": 1.5,
    "beacon": 1.5,
    "speech": 3.0,
    "motions": 3.0,
    "power": 3.0,
}
NEWEST_OTHERS_S = 1.0
"""The age at which a value no longer counts. Ranges, attitude and motors are published at 10 Hz or more. Slower streams
have an entry in `NEWEST_S`, of three of their periods.
"""

Sort = Literal["number", "switch", "text"]
RUN, VARIABLE = "", "$"
"""The names that stand for the run itself and for its variables, in place of a stream."""
DEEPEST = 5


class Key(NamedTuple):
    """The source of a column: a stream and the path within it.

    - `choices`: all possible texts.
    - `turning`: the value is in degrees, and 359 is next to 0.
    - `times`: the factor from the stream's unit to the column's.
    """

    column: str
    stream: str
    path: tuple[str, ...]
    sort: Sort
    choices: tuple[str, ...] = ()
    turning: bool = False
    times: float = 1.0
    low: float = float("-inf")
    high: float = float("inf")

    @property
    def name(self) -> str:
        """Return the dotted path to the value."""
        return ".".join((self.stream, *self.path)) if self.stream else self.column

    @property
    def newest_s(self) -> float:
        """Return the greatest age of its value, unless a cell gives one."""
        return NEWEST_S.get(self.stream, NEWEST_OTHERS_S)

    def read(self, message: object) -> Value | None:
        """Return its value in a message, or None."""
        for part in self.path:
            message = message.get(part) if isinstance(message, dict) else getattr(message, part, None)
            if message is None:
                return None
        if isinstance(message, bool):
            return float(message)
        if isinstance(message, int | float):
            value = float(message) * self.times
            return None if isnan(value) else value
        return message if isinstance(message, str) else None


_OLD: dict[str, tuple[str, float]] = {
    "heading": ("attitude.heading_deg", 1.0),
    "Forward": ("ranges.forward_m", 100.0),
    "Rear": ("ranges.back_m", 100.0),
    "Back": ("ranges.back_m", 100.0),
    "Left": ("ranges.left_m", 100.0),
    "Right": ("ranges.right_m", 100.0),
    "Bottom": ("ranges.bottom_m", 100.0),
    "Amps Left": ("motors.amps_left_a", 1.0),
    "Amps Right": ("motors.amps_right_a", 1.0),
    "Volts": ("battery.voltage_v", 1.0),
    "Dock Left": ("dock.left", 1.0),
    "Dock Right": ("dock.right", 1.0),
    "Dock Power": ("dock.power", 1.0),
}
"""The established columns: distances in centimetres, all others in the stream's own unit."""
_OF_THE_RUN = {
    "Time": Key("Time", RUN, ("time",), "number", low=0.0),
    "Run Time": Key("Run Time", RUN, ("run_time",), "number", low=0.0),
    "Visits": Key("Visits", RUN, ("visits",), "number", low=1.0),
    "Chance": Key("Chance", RUN, ("chance",), "number", low=0.0, high=100.0),
    "Result": Key("Result", RUN, ("result",), "text", choices=tuple(MEANINGS)),
}
"""Columns about the run itself:

- `Time`, `Run Time`: seconds in this state, and since the start.
- `Visits`: how many times the state was entered.
- `Chance`: a number from 0 to 100, drawn on entering the state.
- `Result`: the code of the last command.
"""
COLUMNS = tuple(_OLD) + tuple(_OF_THE_RUN)


EVERY = frozenset(STREAMS)


@lru_cache(maxsize=4096)
def resolve(column: str, streams: frozenset[str] = EVERY) -> Key:
    """Return the key of a column; raise CellError if the name is unknown or ambiguous. `streams` are those of the
    robot; a bare name is looked up among them."""
    if column in _OF_THE_RUN:
        return _OF_THE_RUN[column]
    if column.startswith(VARIABLE):
        if not column[1:].isidentifier():
            raise CellError(f"'{column}' is no variable: after $ comes a name, such as $laps")
        return Key(column, VARIABLE, (column[1:],), "text")
    if column in _OLD:
        path, times = _OLD[column]
        key = _known()[tuple(path.split("."))]
        key = key._replace(column=column, times=times, low=key.low * times, high=key.high * times)
    else:
        key = _anywhere(column, streams)
    if key.stream not in streams:
        raise CellError(f"'{column}' is read from {key.stream}, which this robot does not have")
    return key


def all_names() -> tuple[str, ...]:
    """Return every name of the telemetry as a dotted path; `*` stands for a name from the robot's rows."""
    return tuple(".".join(path) for path in _known())


def _anywhere(column: str, streams: frozenset[str]) -> Key:
    parts = tuple(column.strip().split("."))
    if (exact := _at(parts)) is not None:
        return exact._replace(column=column)
    every = [key for path, key in _known().items() if path[-len(parts) :] == parts]
    fitting = [key for key in every if key.stream in streams] or every[:1]
    if len(fitting) > 1:
        names = ", ".join(key.name for key in fitting)
        alike = [name for name in COLUMNS if name.lower() == column.lower()]
        also = f", or the column {alike[0]} in its own unit" if alike else ""
        raise CellError(f"'{column}' may be {names}: name one by its whole path{also}")
    if not fitting:
        raise CellError(f"there is no '{column}' in the telemetry{_meant(column)}")
    return fitting[0]._replace(column=column)


def _at(parts: tuple[str, ...]) -> Key | None:
    """Return the key at a whole path; names from rows match `*`."""
    for path, key in _known().items():
        same = len(path) == len(parts) and all(one in {"*", part} for one, part in zip(path, parts, strict=True))
        if same and all(parts):
            return key._replace(path=parts[1:])
    return None


def _meant(column: str) -> str:
    last: dict[str, str] = {path[-1]: ".".join(path) for path in _known()}
    close = near(column, (*COLUMNS, *last, *last.values()))
    return f"; did you mean '{close[0]}'?" if close else "; 'lbr behaviour columns' lists what there is"


@cache
def _known() -> dict[tuple[str, ...], Key]:
    return {
        (stream, *path): Key(path[-1], stream, path, *found)
        for stream, message in STREAMS.items()
        for path, found in _fields(message, 0)
    }


def _fields(message: type[Struct], depth: int) -> Iterator[tuple[tuple[str, ...], tuple[Any, ...]]]:
    """Yield the path and properties of each field that a condition can read."""
    for field in msgspec.structs.fields(message):
        yield from _of_type((field.encode_name,), field.type, depth)


def _of_type(path: tuple[str, ...], kind: object, depth: int) -> Iterator[tuple[tuple[str, ...], tuple[object, ...]]]:
    meta: list[object] = []
    while get_origin(kind) is Annotated:
        kind, *more = get_args(kind)
        meta += more
    if get_origin(kind) in {Union, types.UnionType}:
        options = [one for one in get_args(kind) if one is not type(None)]
        if len(options) == 1:
            yield from _of_type(path, options[0], depth)
        return
    if get_origin(kind) is Literal:
        yield path, ("text", tuple(map(str, get_args(kind))))
    elif kind is bool:
        yield path, ("switch", (), False, 1.0, 0.0, 1.0)
    elif kind in {int, float}:
        bounds = {
            name: getattr(each, name) for each in meta for name in ("ge", "le") if getattr(each, name, None) is not None
        }
        turning = path[-1] == "heading_deg"
        low, high = (0.0, 360.0) if turning else (bounds.get("ge", float("-inf")), bounds.get("le", float("inf")))
        yield path, ("number", (), turning, 1.0, low, high)
    elif kind is str:
        yield path, ("text",)
    elif get_origin(kind) is dict and depth < DEEPEST:
        yield from _of_type((*path, "*"), get_args(kind)[1], depth + 1)
    elif isinstance(kind, type) and issubclass(kind, Struct) and depth < DEEPEST:
        yield from ((path + more, found) for more, found in _fields(kind, depth + 1))


Look = Callable[[Key, float], Value | None]
"""Returns the value of a key; None without one that is new enough."""
