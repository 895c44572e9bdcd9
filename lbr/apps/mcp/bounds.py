"""The bounds of a tool's arguments: JSON Schema from rows and messages, and the check against it. Pure."""

import re
from collections.abc import Mapping
from math import isfinite
from typing import Any

from lbr.errors import InputError
from lbr.messages.schema import JsonObject

Schema = JsonObject
KEPT = ("description", "type", "minimum", "maximum", "maxLength", "pattern")
TYPED_MINIMUM = "x-typed-minimum"
"""The least value that a person may type, if the message allows less."""
LONGEST_BRIEF = 60


def fields(pattern: str) -> list[str]:
    """Return the fields of a word's pattern: `power` and `angle_deg` of `/r/{power}/{angle_deg}`."""
    return re.findall(r"\{(\w+)(?:\.\.\.)?\}", pattern)


def of_field(described: Mapping[str, Any], choices: list[Any], most: float | None = None) -> Schema:
    """Return the schema of one field: the message's bounds, the rows' names, and a limit for agents."""
    schema = {name: described[name] for name in KEPT if name in described}
    if TYPED_MINIMUM in described:
        schema["minimum"] = described[TYPED_MINIMUM]
    if most is not None:
        schema["maximum"] = min(most, schema.get("maximum", most))
    if choices:
        schema = {"type": "string", "enum": choices} | {k: schema[k] for k in ("description",) if k in schema}
    return schema or {"type": "string"}


def of_object(properties: Mapping[str, Schema], required: list[str]) -> Schema:
    """Return the schema of a tool's arguments, which allows no others."""
    return {"type": "object", "properties": dict(properties), "required": required, "additionalProperties": False}


def checked(schema: Schema, arguments: Mapping[str, object]) -> JsonObject:
    """Return valid arguments, with the defaults of missing ones; raise InputError with the first that does not fit."""
    properties: dict[str, Schema] = schema["properties"]
    if unknown := [name for name in arguments if name not in properties]:
        known = ", ".join(properties) or "none"
        raise InputError(f"there is no argument '{brief(unknown[0])}'; the arguments are: {known}", "unknown_name")
    if missing := [name for name in schema["required"] if name not in arguments]:
        raise InputError(f"'{missing[0]}' is missing: {allowed(properties[missing[0]])}")
    values = {name: schema["default"] for name, schema in properties.items() if "default" in schema}
    for name, value in arguments.items():
        if not fits(properties[name], value):
            raise InputError(f"'{name}' is {brief(value)}, and must be {allowed(properties[name])}")
        values[name] = value
    return values


def fits(schema: Schema, value: Any) -> bool:
    """Return whether a value fits a schema; NaN and infinity never do."""
    if "enum" in schema:
        return isinstance(value, str) and value in schema["enum"]
    if schema.get("type") == "number":
        number = isinstance(value, int | float) and not isinstance(value, bool)
        low, high = schema.get("minimum", float("-inf")), schema.get("maximum", float("inf"))
        return number and isfinite(value) and low <= value <= high
    if schema.get("type") == "object":
        return isinstance(value, Mapping)
    if not isinstance(value, str) or len(value) > schema.get("maxLength", len(value)):
        return False
    return "pattern" not in schema or re.search(schema["pattern"], value) is not None


def allowed(schema: Schema) -> str:
    """Describe the allowed values."""
    if "enum" in schema:
        return f"one of {', '.join(schema['enum'])}"
    if schema.get("type") == "number":
        bounds = [f"{schema[name]:g}" for name in ("minimum", "maximum") if name in schema]
        return f"a number from {' to '.join(bounds)}" if bounds else "a number"
    if "maxLength" in schema:
        return f"a text of at most {schema['maxLength']} characters"
    return f"a {schema.get('type', 'text')}"


def brief(value: object) -> str:
    """Return an agent's value for a sentence: short, and one line."""
    text = repr(value) if not isinstance(value, str) else value
    text = "".join(one if one.isprintable() else "?" for one in text[:LONGEST_BRIEF])
    return text + ("…" if len(str(value)) > LONGEST_BRIEF else "")
