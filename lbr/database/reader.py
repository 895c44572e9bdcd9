"""Reads one raw row column by column, noting what is wrong instead of raising."""

import json
import math
import re
from collections.abc import Mapping
from typing import Any, NoReturn, TypeVar

from lbr.database.rows import Problem

NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")
END = re.compile(r"[a-z][a-z0-9_]{0,39}\.[a-z][a-z0-9_]{0,39}")
MAX_TEXT = 100_000
_HALF = re.compile("[\ud800-\udfff]")

_NOTED = object()  # instead of a value whose fault has been noted

T = TypeVar("T")


class RowReader:
    """One row: every method returns a column's checked value, or notes a problem and returns a harmless stand-in."""

    def __init__(self, table: str, key: tuple[str, ...], values: Mapping[str, Any], problems: list[Problem]) -> None:
        self.table = table
        self.bad: set[str] = set()
        self._key = key
        self._values = values
        self._problems = problems

    @property
    def label(self) -> str:
        """Return the row's key as people read it."""
        return "/".join(shown(self._values.get(column)) for column in self._key)

    def good(self, *columns: str) -> bool:
        """Say whether nothing was wrong with these columns so far."""
        return self.bad.isdisjoint(columns)

    def wrong(self, column: str, text: str) -> None:
        """Note a problem; the row is not good any more."""
        self.bad.add(column)
        self._problems.append(Problem(self.table, self.label, column, text))

    def text(self, column: str, *, empty: bool = True, null: bool = False) -> str:
        """Return a text; `null` lets NULL be the empty text."""
        value = self._values.get(column)
        if value is None and null:
            return ""
        if not isinstance(value, str):
            return self._stand_in(column, f"is {_type(value)}, not a text", "")
        if fault := text_fault(value):
            return self._stand_in(column, fault, "")
        if not value.strip() and not empty:
            return self._stand_in(column, "is empty", "")
        return value

    def matching(self, column: str, pattern: re.Pattern[str], meant: str) -> str:
        """Return a text that is all of `pattern`."""
        value = self._values.get(column)
        if isinstance(value, str) and pattern.fullmatch(value):
            return value
        return self._stand_in(column, f"'{shown(value)}' is not {meant}", "")

    def name(self, column: str) -> str:
        """Return a row's name."""
        return self.matching(column, NAME, "a name (small letters, digits, underscores; at most 40)")

    def end(self, column: str) -> str:
        """Return a `capability.port`."""
        return self.matching(column, END, "of the form capability.port")

    def flag(self, column: str) -> bool:
        """Return a 0 or 1."""
        value = self._values.get(column)
        if isinstance(value, int) and value in (0, 1):
            return value == 1
        return self._stand_in(column, f"'{shown(value)}' is neither 0 nor 1", default=False)

    def whole(self, column: str, lowest: int, highest: int) -> int:
        """Return a whole number within bounds."""
        value = self._values.get(column)
        if isinstance(value, int) and lowest <= value <= highest:
            return value
        return self._stand_in(column, f"'{shown(value)}' is not a whole number from {lowest} to {highest}", lowest)

    def number(self, column: str) -> float:
        """Return a finite number."""
        value = self._values.get(column)
        if isinstance(value, int | float) and math.isfinite(value):
            return float(value)
        return self._stand_in(column, f"'{shown(value)}' is not a finite number", 0.0)

    def within(self, column: str, lowest: float, highest: float) -> float:
        """Return a number within bounds."""
        value = self.number(column)
        if lowest <= value <= highest:
            return value
        return self._stand_in(column, f"{value:g} is outside {lowest:g} to {highest:g}", lowest)

    def rate(self, column: str) -> float | None:
        """Return a rate above zero, or None for none."""
        value = self._values.get(column)
        if value is None:
            return None
        if isinstance(value, int | float) and 0 < value <= 1_000_000:
            return float(value)
        return self._stand_in(column, f"'{shown(value)}' is not above 0 and at most 1000000 (or NULL)", None)

    def choice(self, column: str, allowed: tuple[T, ...]) -> T:
        """Return one of the allowed values."""
        value = self._values.get(column)
        for one in allowed:
            if one == value:
                return one
        return self._stand_in(column, f"'{shown(value)}' is none of {', '.join(map(str, allowed))}", allowed[0])

    def json_object(self, column: str) -> dict[str, Any]:
        """Return a JSON object."""
        value = self._json(column)
        if isinstance(value, dict):
            return value
        return {} if value is _NOTED else self._stand_in(column, 'is not a JSON object like {"key": 1}', {})

    def json_texts(self, column: str) -> tuple[str, ...]:
        """Return a JSON list of texts."""
        value = self._json(column)
        if isinstance(value, list) and all(isinstance(item, str) and not text_fault(item) for item in value):
            return tuple(value)
        return () if value is _NOTED else self._stand_in(column, 'is not a JSON list of strings like ["a", "b"]', ())

    def json_list(self, column: str) -> list[Any]:
        """Return a JSON list."""
        value = self._json(column)
        if isinstance(value, list):
            return value
        return [] if value is _NOTED else self._stand_in(column, 'is not a JSON list like ["a", "b"]', [])

    def _json(self, column: str) -> Any:
        before = len(self._problems)
        text = self.text(column)
        if len(self._problems) > before:
            return _NOTED
        try:
            return json_strictly(text)
        except (ValueError, RecursionError) as err:
            fault = "nested too deeply" if isinstance(err, RecursionError) else str(err)
            return self._stand_in(column, f"is not JSON: {fault}", _NOTED)

    def _stand_in(self, column: str, text: str, default: T) -> T:
        self.wrong(column, text)
        return default


def shown(value: object) -> str:
    """Return a value as one short printable line."""
    text = value.decode(errors="replace") if isinstance(value, bytes) else str(value)
    return "".join(c if c.isprintable() else "?" for c in text[:60]) + ("…" if len(text) > 60 else "")


def text_fault(text: str) -> str:
    """Return why a text cannot be used, or nothing."""
    if len(text) > MAX_TEXT:
        return f"is longer than {MAX_TEXT} characters"
    if "\0" in text:
        return "contains a NUL character"
    if not text.isascii() and _HALF.search(text):
        return "is not valid UTF-8"
    return ""


def json_strictly(text: str) -> Any:
    """Decode JSON; doubled keys, NaN, numbers beyond 64 bits and half characters are ValueErrors too."""
    value = json.loads(text, object_pairs_hook=_pairs, parse_constant=_constant, parse_float=_finite, parse_int=_short)
    json.dumps(value, ensure_ascii=False).encode()
    return value


def _pairs(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a key stands twice in one object")
    return found


def _constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is no number")


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text[:30]} is too large")
    return value


def _short(text: str) -> int:
    if len(text) > 20 or not -(2**63) <= int(text) < 2**63:
        raise ValueError(f"{text[:30]} is too large")
    return int(text)


def _type(value: object) -> str:
    names = {type(None): "NULL", bytes: "a blob", int: "a number", float: "a number", str: "a text"}
    return names.get(type(value), type(value).__name__)
