"""The content of a request to /motor or /multimotor, by the API's original rules and their order."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isnan
from typing import TypeGuard

from lbr.apps.web.face import Refused
from lbr.messages.faces import Motor
from lbr.robots.uxa90.rest.answers import Number
from lbr.robots.uxa90.rest.counts import STRONGEST, WEAKEST
from lbr.robots.uxa90.rest.number import clamped, nearest, number, of_json, plain, written
from lbr.robots.uxa90.rest.table import UNITS, MotorTable

Query = Mapping[str, Sequence[str]]
LONGEST_DELAY_MS = 600_000
MOST_ITEMS = 200
EXAMPLE = '{"motors": [{"id": 23, "pos": 100, "torq": 0}]}'
POSITIONS = ("pos", "position")
TORQUES = ("torq", "torque")
TORQUES_IN_BODY = ("torq", "torque", "toqr")
"""The names of the torque in a body; the last is a common misspelling."""


@dataclass(frozen=True, slots=True)
class Turn:
    """One motor's move to a count, at a level of torque, after a delay from the request."""

    motor: Motor
    position: Number
    count: int
    level: int
    delay_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Move:
    """A move of one motor; `torq` as it is echoed."""

    turn: Turn
    torq: Number


def unit_of(query: Query) -> str:
    """Return the unit of positions; empty means counts."""
    unit = _once(query, "unit")
    if unit is not None and unit not in UNITS:
        raise Refused(400, f"unit '{unit[:20]}' is not one of {', '.join(UNITS)}")
    return unit or ""


def flag(query: Query, name: str) -> bool:
    """Return the value of a switch; missing means false."""
    text = _once(query, name)
    if text not in {None, "", "true", "false", "1", "0"}:
        raise Refused(400, f"{name} must be true or false")
    return text in {"true", "1"}


def of_motor(table: MotorTable, query: Query) -> Move | Motor | None:
    """Return the content of GET /motor: a move, one motor to read, or None for the list."""
    if "id" not in query:
        return None
    ids = query["id"]
    motor = table.find(number(ids[0]) if len(ids) == 1 else float("nan"))
    position, torque = _text(query, POSITIONS), _text(query, TORQUES)
    unit = unit_of(query)
    if position is None:
        if torque is not None:
            raise Refused(400, "torq is of no use without pos: give the position to go to as well")
        return motor
    value = number(position)
    if isnan(value):
        raise Refused(400, f"pos must be a number ({motor.lowest} to {motor.highest}), not '{position[:20]}'")
    torq = 0.0 if torque is None else number(torque)
    if isnan(torq):
        raise Refused(400, f"torq must be a number (0, the strongest, to 4), not '{(torque or '')[:20]}'")
    delay = _once(query, "delay")
    delay_s = 0.0 if delay is None else _delay_s(number(delay))
    torq = plain(clamped(torq, STRONGEST, WEAKEST))
    at = table.from_unit(motor, value, unit)
    return Move(Turn(motor, at, table.target(motor, at), nearest(torq), delay_s), torq)


def of_motors(table: MotorTable, body: object, query: Query) -> list[tuple[Turn, dict[str, object]]]:
    """Return each motor's move for /multimotor, with its echo; all of them before anything moves."""
    unit = unit_of(query)
    items = body.get("motors") if isinstance(body, dict) else None
    if not isinstance(items, list):
        raise Refused(400, f"the body must be an object with a list: {EXAMPLE}")
    if len(items) > MOST_ITEMS:
        raise Refused(400, f"{len(items)} motors are too many for one request; {MOST_ITEMS} are allowed")
    return [_item(table, item, at, unit) for at, item in enumerate(items)]


def _item(table: MotorTable, item: object, at: int, unit: str) -> tuple[Turn, dict[str, object]]:
    if not isinstance(item, dict):
        raise Refused(400, f'motors[{at}] must be an object such as {{"id": 23, "pos": 100, "torq": 0}}')
    wanted = item.get("id")
    if not _is_number(wanted):
        raise Refused(409, f"Motor '{_named(wanted)}' doesn't exist", code="unknown_name")
    motor = table.find(of_json(wanted))
    key = next((key for key in POSITIONS if key in item), "pos")
    value = item.get(key)
    if not _is_number(value):
        raise Refused(400, f"motors[{at}].{key} must be a number ({motor.lowest} to {motor.highest})")
    torque_key = next((key for key in TORQUES_IN_BODY if key in item), "torq")
    torq = item.get(torque_key, 0)
    if not _is_number(torq):
        raise Refused(400, f"motors[{at}].{torque_key} must be a number (0, the strongest, to 4)")
    delay = item.get("delay", 0)
    if not _is_number(delay):
        raise Refused(400, f"motors[{at}].delay must be a number of milliseconds (0 to {LONGEST_DELAY_MS})")
    position = table.from_unit(motor, of_json(value), unit)
    torq = plain(clamped(of_json(torq), STRONGEST, WEAKEST))
    turn = Turn(motor, position, table.target(motor, position), nearest(torq), _delay_s(of_json(delay)))
    shown = position if unit in {"", "raw"} else value
    return turn, item | {key: shown, torque_key: torq}


def _is_number(value: object) -> TypeGuard[int | float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _named(value: object) -> str:
    """Return JavaScript's text for a value that should have been a number."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if value is None or isinstance(value, str):
        return (value if value is not None else "undefined")[:40]
    return "NaN"


def _text(query: Query, names: tuple[str, str]) -> str | None:
    """Return the value of the short name or else the long one; an empty short one counts as missing."""
    short, long = (_once(query, name) for name in names)
    return short or long


def _once(query: Query, name: str) -> str | None:
    values = query.get(name)
    if values is None:
        return None
    if len(values) != 1:
        raise Refused(400, f"{name} was given {len(values)} times; give it once")
    return values[0]


def _delay_s(delay_ms: float) -> float:
    if not 0.0 <= delay_ms <= LONGEST_DELAY_MS:  # this way round, NaN is none
        raise Refused(400, f"delay is milliseconds, 0 to {LONGEST_DELAY_MS}, not {written(delay_ms)}")
    return delay_ms / 1000.0
