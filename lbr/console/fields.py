"""The fields of a verb's message: typed text becomes a checked value, or a sentence with the permitted values."""

import math
import re
from collections.abc import Mapping
from functools import cache
from typing import Any

import msgspec
from msgspec import Struct

from lbr.console.printable import listed
from lbr.errors import InputError
from lbr.messages.in_words import MEANT
from lbr.messages.rows import short
from lbr.messages.units import NAME_OR_NONE_PATTERN, NAME_PATTERN

Schema = Mapping[str, Any]
MessageType = type[Struct] | Schema

TYPED_MINIMUM = "x-typed-minimum"
"""The key in a schema for the lowest typed value, if the message permits a lower one."""

_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)", re.ASCII)
_WHOLE = re.compile(r"[+-]?[0-9]{1,18}", re.ASCII)
_UNITS = {
    "deg": "degrees",
    "rad": "radians",
    "cm": "cm",
    "m": "m",
    "s": "seconds",
    "dps": "degrees a second",
    "ms": "ms",
    "v": "volts",
    "hz": "Hz",
    "percent": "percent",
}
_NAMES = (NAME_PATTERN, NAME_OR_NONE_PATTERN)
"""Names have no capitals: a typed capital, as in Forward, means the small letter."""
_FLAGS = {"true": True, "yes": True, "1": True, "on": True, "false": False, "no": False, "0": False, "off": False}


class Field(Struct, frozen=True):
    """One field as JSON Schema describes it."""

    name: str
    schema: dict[str, Any]

    @property
    def word(self) -> str:
        """Return the name for people, without its unit."""
        stem, _, unit = self.name.rpartition("_")
        return stem if stem and unit in _UNITS else self.name

    @property
    def unit(self) -> str:
        """Return the unit in words; empty if it has none."""
        return _UNITS.get(self.name.rpartition("_")[2], "") if self.word != self.name else ""

    @property
    def choices(self) -> tuple[str, ...]:
        """Return the permitted texts; empty if it is not a choice."""
        return tuple(str(value) for value in self.schema.get("enum", ()))

    @property
    def items(self) -> "Field | None":
        """Return the field of a list's items; None if it is not a list."""
        return Field(self.name, self.schema.get("items", {})) if self.schema.get("type") == "array" else None

    @property
    def allowed(self) -> str:
        """Return the permitted values in words: `0 to 1`, `-360 to 360 degrees`, `forward, back or left`."""
        if self.choices:
            return listed(list(self.choices))
        if self.items is not None:
            return f"{self.items.allowed}, or several with commas"
        typed = self.schema.get(TYPED_MINIMUM)
        low = _bound(self.schema, "inimum") if typed is None else f"{typed:g}"
        high = _bound(self.schema, "aximum")
        kind = self.schema.get("type")
        if kind not in {"number", "integer"}:
            return {"boolean": "yes or no"}.get(str(kind), "a text")
        bounds = f"{low} to {high}" if low and high else ""
        if bounds and typed is None and "exclusiveMinimum" in self.schema:
            bounds = f"above {low}, up to {high}"
        open_ended = (low and f"at least {low}") or (high and f"at most {high}")
        whole = "a whole number" if kind == "integer" else "a number"
        return " ".join(filter(None, [bounds or open_ended or whole, self.unit]))

    def read(self, text: str) -> Any:
        """Return the value of a piece of a line; raise InputError with the permitted values."""
        if self.choices:
            return self._choice(text)
        if self.items is not None:
            return [self.items.read(part.strip()) for part in text.split(",")]
        kind = self.schema.get("type")
        if kind in {"number", "integer"}:
            return self._number(text, whole=kind == "integer")
        if kind == "boolean":
            if text.lower() not in _FLAGS:
                raise self._wrong(text)
            return _FLAGS[text.lower()]
        return self._text(text)

    def _wrong(self, text: str) -> InputError:
        quoted = text if _NUMBER.fullmatch(text) and len(text) < 20 else f"'{short(text)}'"
        return InputError(f"{self.word} is {self.allowed}, not {quoted}")

    def _choice(self, text: str) -> object:
        for value in self.schema["enum"]:
            if str(value).lower() == text.lower():
                return value
        raise self._wrong(text)

    def _number(self, text: str, *, whole: bool) -> float:
        if not (_WHOLE if whole else _NUMBER).fullmatch(text):
            raise self._wrong(text)
        value = int(text) if whole else float(text)
        schema = self.schema
        fits = (
            math.isfinite(value)
            and schema.get(TYPED_MINIMUM, schema.get("minimum", -math.inf)) <= value <= schema.get("maximum", math.inf)
            and schema.get("exclusiveMinimum", -math.inf) < value < schema.get("exclusiveMaximum", math.inf)
        )
        if not fits:
            raise self._wrong(text)
        return value

    def _text(self, text: str) -> str:
        longest = self.schema.get("maxLength")
        if longest is not None and len(text) > longest:
            raise InputError(f"{self.word} has {len(text)} characters; {longest} are allowed")
        if len(text) < self.schema.get("minLength", 0):
            raise InputError(f"{self.word} is too short; at least {self.schema['minLength']} characters")
        pattern = self.schema.get("pattern")
        if pattern in _NAMES and re.search(pattern, text.lower()):
            return text.lower()
        if pattern is not None and not re.search(pattern, text):
            meant, asked = MEANT.get(pattern), short(pattern.replace("$(?!\\n)", "$"))
            why = f"is not {meant}" if meant else f"does not fit the pattern {asked}"
            raise InputError(f"{self.word} '{short(text)}' {why}")
        return text


class Message:
    """The fields of a target, and the check of the whole."""

    def __init__(self, of: MessageType | None) -> None:
        self._type = of if isinstance(of, type) else None
        self._known = of is not None
        schema = _schema(of) if isinstance(of, type) else dict(of or {})
        self._properties, self._required, self._definitions = _properties(schema)

    def field(self, name: str) -> Field:
        """Return a field; without a type, it is a text."""
        return Field(name, _resolved(self._properties.get(name, {"type": "string"}), self._definitions))

    def check(self, payload: Mapping[str, object]) -> None:
        """Raise InputError if the fields together make no message."""
        if self._type is not None:
            try:
                msgspec.convert(payload, self._type)
            except msgspec.ValidationError as err:
                raise InputError(f"this makes no valid message: {short(err)}") from None
        missing = [name for name in self._required if name not in payload]
        if missing:
            raise InputError(f"this makes no valid message: {listed(missing, 'and')} is missing in the verb's row")


def properties(schema: Schema) -> list[Field]:
    """Return the fields that a JSON Schema describes."""
    found, _, definitions = _properties(schema)
    return [Field(name, _resolved(one, definitions)) for name, one in found.items()]


@cache
def _schema(of: type[Struct]) -> Schema:
    return msgspec.json.schema(of)


def _bound(schema: Schema, which: str) -> str:
    for key in (f"m{which}", f"exclusiveM{which}"):
        if key in schema:
            return f"{schema[key]:g}"
    return ""


def _properties(schema: Schema) -> tuple[Schema, tuple[str, ...], Schema]:
    definitions = schema.get("$defs", {})
    body = _resolved(schema, definitions)
    return body.get("properties", {}), tuple(body.get("required", ())), definitions


def _resolved(schema: Schema, definitions: Schema) -> dict[str, Any]:
    reference = schema.get("$ref", "")
    if reference:
        return dict(definitions.get(reference.rpartition("/")[2], {}))
    options = [one for one in schema.get("anyOf", ()) if one.get("type") != "null"]
    if not options:
        return dict(schema)
    return _resolved(next((one for one in options if one.get("type") == "string"), options[0]), definitions)
