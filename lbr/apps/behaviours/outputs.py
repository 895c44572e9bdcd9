"""The orders of a row: from its output cells to commands of the robot. Pure.

A number may be a variable, `$speed`. Of alternatives, `a | b`, one is drawn when the row is taken.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from math import isfinite, isnan
from typing import NamedTuple, TypeVar, get_args

import msgspec
from msgspec import Struct

from lbr.apps.behaviours.cells import Value
from lbr.messages.beacon import MANOEUVRES, SeekCommand
from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand
from lbr.messages.joints import PlayCommand
from lbr.messages.sighting import WatchCommand
from lbr.messages.speech import SayCommand
from lbr.messages.tracking import Target
from lbr.messages.units import NAME_PATTERN
from lbr.names import near

C = TypeVar("C", bound=Struct)
ALONG = ("range", "sensor", "distance", "duration", "angle")
NUMBERS = ("level", "angle", "range", "distance", "duration", "heading", "turn", "wait", "times", "retry")
TEXTS = ("sensor", "speech", "phrase", "watch", "motion", "beacon", "run", "set")
ALL = (*NUMBERS, *TEXTS)
MOST_RETRIES = 20
MOST_CHOICES = 20
"""The alternatives of one cell; each of them is checked when a table is read."""
LONGEST_WAIT_S = 3600.0
WAYS = {
    "level": "move",
    "turn": "turn",
    "heading": "heading",
    "motion": "play",
    "beacon": "seek",
    "speech": "say",
    "phrase": "say",
    "watch": "watch",
}
"""The request that carries out each output."""
NEEDS = {
    "move": "drive",
    "turn": "drive",
    "heading": "drive",
    "play": "motions",
    "seek": "beacon",
    "say": "speech",
    "watch": "sighting",
}
ASIDE = frozenset({"say", "watch"})
"""Side requests: a table neither waits for them nor fails without them."""
OFF = "off"
_SENSORS = {"rear": "back"}
"""Other names of sensors in old tables."""
_ASSIGNS = re.compile(r"\s*\$?(\w+)\s*(=|\+=|-=)\s*(.*?)\s*\Z")
Draw = Callable[[int], int]
"""Returns a random number from 0 to n - 1."""


class Wait(Struct, frozen=True):
    """Stand still for a time."""

    seconds: float


class Halt(Struct, frozen=True):
    """Stand still."""


class CallTable(Struct, frozen=True):
    """Run another table to its end."""

    name: str


class Assign(Struct, frozen=True):
    """Change a variable."""

    name: str
    how: str
    value: Value


Motion = DriveCommand | TurnCommand | HeadingCommand | PlayCommand | SeekCommand
Aside = SayCommand | WatchCommand
Order = Wait | Halt | CallTable | Assign | Aside | Motion


class Orders(NamedTuple):
    """The orders of one row in sequence, and how often to retry a motion or a table that failed."""

    orders: tuple[Order, ...] = ()
    retries: int = 0


class OutputError(ValueError):
    """An output that makes no command: its column, and why."""

    def __init__(self, column: str, text: str) -> None:
        super().__init__(text)
        self.column = column


def sensors(cells: Mapping[str, str]) -> tuple[str, ...]:
    """Return the sensors that end a motion, by their rows' names."""
    if not cells.get("range", "").strip():
        return ()
    named = [one.strip().lower() for one in cells.get("sensor", "forward").split("|")]
    return tuple(_SENSORS.get(name, name) for name in named)


def described(order: Order) -> str:
    """Return the description of an order, for people."""
    if isinstance(order, DriveCommand):
        return _drive_described(order)
    if isinstance(order, WatchCommand):
        return f"look for a {order.target}" if order.seconds else "look for nothing"
    patterns = {
        TurnCommand: "turn by {0.angle_deg:g}°",
        HeadingCommand: "turn to {0.heading_deg:g}°",
        PlayCommand: "play {0.motion}",
        SeekCommand: "{0.manoeuvre} by the dock's beams",
        SayCommand: "say {0.phrase}{0.text}",
        Wait: "wait {0.seconds:g} s",
        CallTable: "run {0.name}",
        Assign: "${0.name} {0.how} {0.value}",
        Halt: "stand still",
    }
    return patterns[type(order)].format(order)


def _drive_described(order: DriveCommand) -> str:
    ends = [
        f"{word} {value:g} {unit}"
        for word, value, unit in (
            (f"until {order.sensor} is", order.range_cm, "cm"),
            ("for", order.distance_cm, "cm"),
            ("for", order.interval_s, "s"),
        )
        if value
    ]
    return " ".join((f"drive at {order.power:g} towards {order.angle_deg:g}°", *ends))


def make(cells: Mapping[str, str], draw: Draw, variables: Mapping[str, Value]) -> Orders:
    """Return the orders of output cells now; raise OutputError with the column at fault."""
    given = {name: _chosen(text, draw) for name, text in cells.items() if text.strip()}
    numbers = {name: _number(name, given[name], variables) for name in NUMBERS if name in given}
    orders = list(_orders(given, numbers))
    retries = _within("retry", numbers.get("retry", 0.0), MOST_RETRIES)
    return Orders(tuple(orders), 0 if isnan(retries) else int(retries))


def faults(cells: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Yield each faulty column and the reason; all alternatives of a cell are checked."""
    for name in cells:
        if name not in ALL:
            close = near(name, ALL)
            meant = f"did you mean O:{close[0]}?" if close else f"there is {', '.join(ALL)}"
            yield name, f"no command takes it; {meant}"
    known = {name: text for name, text in cells.items() if name in ALL}
    for name, text in known.items():
        if text.count("|") >= MOST_CHOICES:
            yield name, f"it is one of {text.count('|') + 1}, and {MOST_CHOICES} are the most"
            return
    most = max((len(text.split("|")) for text in known.values()), default=1)
    wrong: dict[str, str] = {}
    for number in range(most):
        try:
            make(known, lambda count, number=number: min(number, count - 1), _Unset())  # type: ignore[misc]
        except OutputError as err:
            wrong.setdefault(err.column, str(err))
    yield from wrong.items()


def variables_of(cells: Mapping[str, str]) -> set[str]:
    """Return the variables that cells set."""
    return {found[1] for part in cells.get("set", "").split(";") if (found := _ASSIGNS.match(part))}


class _Unset(dict[str, Value]):
    """Variables without values yet: a check reads each as NaN, which fits everywhere."""

    def __contains__(self, _name: object) -> bool:
        return True

    def __getitem__(self, _name: str) -> Value:
        return float("nan")


def _orders(given: Mapping[str, str], numbers: Mapping[str, float]) -> Iterator[Order]:
    duration = numbers.get("duration", 0.0)
    if duration < 0.0:
        yield Wait(_within("duration", -duration, LONGEST_WAIT_S))
    yield from _assigned(given.get("set", ""))
    if "speech" in given or "phrase" in given:
        text, phrase = given.get("speech", ""), given.get("phrase", "")
        yield _command(SayCommand, {"text": ("speech", text), "phrase": ("phrase", phrase)})
    if "watch" in given:
        yield _watch(given["watch"])
    way = _way(given)
    if way:
        yield _moving(way, given, numbers, max(0.0, duration))
    elif duration > 0.0:
        yield Wait(_within("duration", duration, LONGEST_WAIT_S))
    if "wait" in numbers:
        yield Wait(_within("wait", numbers["wait"], LONGEST_WAIT_S))


def _way(given: Mapping[str, str]) -> str:
    """Return the output that moves the robot, or ""; raise OutputError for outputs that do not go together."""
    moving = [name for name in ("level", "turn", "heading", "motion", "beacon", "run") if name in given]
    if len(moving) > 1:
        raise OutputError(moving[1], f"a row moves the robot in one way, and O:{moving[0]} is one already")
    way = moving[0] if moving else ""
    alone = [name for name in ALONG if name in given and way != "level" and (way or name != "duration")]
    if alone:
        also = f", not with O:{way}" if way else ""
        raise OutputError(alone[0], f"O:{alone[0]} goes with O:level alone{also}")
    if "times" in given and way != "motion":
        raise OutputError("times", "O:times goes with O:motion")
    return way


def _moving(way: str, given: Mapping[str, str], numbers: Mapping[str, float], duration: float) -> Order:
    if way == "level":
        return _drive(given, numbers, duration)
    if way == "run":
        if not re.fullmatch(NAME_PATTERN, given["run"]):
            raise OutputError("run", f"'{given['run']}' is no table's name: small letters, digits, underscores")
        return CallTable(given["run"])
    fields: dict[str, tuple[str, Value]]
    if way == "motion":
        if not re.fullmatch(NAME_PATTERN, given["motion"]):
            raise OutputError("motion", f"'{given['motion']}' is no motion's name: small letters, digits, underscores")
        fields = {"motion": ("motion", given["motion"]), "times": ("times", _whole(numbers))}
        return _command(PlayCommand, fields)
    if way == "beacon":
        return _seek(given["beacon"])
    if way == "turn":
        return _command(TurnCommand, {"angle_deg": ("turn", numbers["turn"])})
    return _command(HeadingCommand, {"heading_deg": ("heading", numbers["heading"])})


def _watch(text: str) -> Order:
    wanted = text.strip().lower()
    if wanted == OFF:
        return WatchCommand(seconds=0.0)
    target = next((one for one in get_args(Target) if one == wanted), None)
    if target is None:
        raise OutputError(
            "watch", f"'{text[:40]}' is not looked for: there is {', '.join(get_args(Target))}, and {OFF}"
        )
    return WatchCommand(target=target)


def _seek(text: str) -> Order:
    manoeuvre = next((one for one in MANOEUVRES if one == text.strip().lower()), None)
    if manoeuvre is None:
        raise OutputError("beacon", f"'{text[:40]}' is no manoeuvre: there is {', '.join(MANOEUVRES)}")
    return SeekCommand(manoeuvre=manoeuvre)


def _drive(given: Mapping[str, str], numbers: Mapping[str, float], duration: float) -> Order:
    if numbers["level"] == 0.0:
        return Halt()
    if "sensor" in given and "range" not in given:
        raise OutputError("sensor", "O:sensor goes with O:range, at which it stops")
    sensor = given.get("sensor", "forward").lower()
    fields: dict[str, tuple[str, Value]] = {
        "power": ("level", numbers["level"]),
        "angle_deg": ("angle", numbers.get("angle", 0.0)),
        "interval_s": ("duration", duration),
        "distance_cm": ("distance", numbers.get("distance", 0.0)),
    }
    if numbers.get("range", 0.0):
        fields |= {"range_cm": ("range", numbers["range"]), "sensor": ("sensor", _SENSORS.get(sensor, sensor))}
    return _command(DriveCommand, fields)


def _command(kind: type[C], fields: Mapping[str, tuple[str, Value]]) -> C:
    """Make a command; raise OutputError with the column of a bad field. Numbers not known yet are left out."""
    known = {name: value for name, (_, value) in fields.items() if not _unknown(value)}
    base = _fitting(kind)
    for name, value in known.items():
        try:
            msgspec.convert({**base, name: value}, kind)
        except msgspec.ValidationError as err:
            raise OutputError(fields[name][0], str(err).partition(" - at")[0]) from err
    return msgspec.convert({**base, **known}, kind)


def _fitting(kind: type[Struct]) -> dict[str, Value]:
    """Return a valid value for each required field of a command."""
    return {
        field.name: "a" if field.name == "motion" else 0.0 for field in msgspec.structs.fields(kind) if field.required
    }


def _assigned(text: str) -> Iterator[Order]:
    for part in text.split(";") if text.strip() else ():
        match = _ASSIGNS.match(part)
        if match is None or not match[1].isidentifier() or not match[3]:
            raise OutputError(
                "set", f"'{part.strip()}' sets nothing: write laps = 0, or laps += 1; several with ; between"
            )
        name, how, value = match.groups()
        try:
            number: Value = float(value)
        except ValueError:
            number = value
        if how != "=" and isinstance(number, str):
            raise OutputError("set", f"'{value}' is no number to be added to ${name}")
        if not (isinstance(number, str) or isfinite(number)):
            raise OutputError("set", f"'{value}' is no number that can be reckoned with")
        yield Assign(name, how, number)


def _chosen(text: str, draw: Draw) -> str:
    several = [one.strip() for one in text.split("|")]
    return several[draw(len(several))] if len(several) > 1 else several[0]


def _number(name: str, text: str, variables: Mapping[str, Value]) -> float:
    if text.startswith("$"):
        if text[1:] not in variables:
            raise OutputError(name, f"the variable {text} has no value yet: O:set gives it one")
        value = variables[text[1:]]
        if isinstance(value, str):
            raise OutputError(name, f"the variable {text} is '{value}', which is no number")
        return value
    try:
        number = float(text)
    except ValueError:
        raise OutputError(name, f"'{text[:40]}' is no number") from None
    if not abs(number) <= 1e9:
        raise OutputError(name, f"{text} is no number that a command takes")
    return number


def _whole(numbers: Mapping[str, float]) -> float:
    """Return how many times to play; a whole number as an int."""
    times = numbers.get("times", 1.0)
    return times if isnan(times) or times != int(times) else int(times)


def _within(name: str, value: float, most: float) -> float:
    """Return a number within its bounds, or one not known yet; else raise OutputError."""
    if not (isnan(value) or 0.0 <= value <= most):
        raise OutputError(name, f"{value:g} is not from 0 to {most:g}")
    return value


def _unknown(value: object) -> bool:
    """Return whether a value is of a variable not known yet."""
    return isinstance(value, float) and isnan(value)
