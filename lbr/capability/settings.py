"""All faults of settings at once: msgspec itself stops at the first one."""

from collections.abc import Iterable
from typing import Any

import msgspec
from msgspec import Struct, inspect

from lbr.capability.border import border
from lbr.capability.choices import with_choices
from lbr.names import near

MOST_TOLD = 20


def decoded(content: str | bytes, kind: object) -> Any:
    """Return a value from JSON. Every exception of a user's own struct becomes a msgspec.ValidationError."""
    with border(lambda err: msgspec.ValidationError(f"{type(err).__name__}: {err}"), msgspec.MsgspecError):
        return msgspec.json.decode(content, type=kind)


def faults(kind: type[Struct], settings: object, at: str = "$") -> tuple[str, ...]:
    """Return the objections to the fields of decoded JSON, in msgspec's words; empty if all fit."""
    try:
        decoded(msgspec.json.encode(settings), kind)
    except msgspec.ValidationError as err:
        found = _of_fields(kind, settings, at) if isinstance(settings, dict) and at.count(".") < MOST_TOLD else []
        return tuple(found[:MOST_TOLD]) or (_placed(str(err), at),)
    return ()


def _of_fields(kind: type[Struct], settings: dict[str, object], at: str) -> list[str]:
    config = kind.__struct_config__
    if config.tag is not None or config.array_like:
        return []
    fields = {field.encode_name: field for field in msgspec.structs.fields(kind)}
    wrong = []
    if config.forbid_unknown_fields:
        wrong += [
            _placed(f"Object contains unknown field `{name}`{_meant(name, fields)}", at)
            for name in settings
            if name not in fields
        ]
    for name, field in fields.items():
        if name not in settings:
            if field.required:
                wrong.append(_placed(f"Object missing required field `{name}`", at))
        else:
            wrong += _of_value(field.type, settings[name], f"{at}.{name}")
    return wrong


def _meant(name: str, fields: Iterable[str]) -> str:
    """Return the field that was probably meant, or all fields."""
    if close := near(name, fields):
        return f", did you mean `{close[0]}`?"
    return f", there is {', '.join(sorted(fields)) or 'none'}"


def _of_value(kind: object, value: object, at: str) -> tuple[str, ...]:
    if isinstance(kind, type) and issubclass(kind, Struct):
        return faults(kind, value, at)
    try:
        decoded(msgspec.json.encode(value), kind)
    except msgspec.ValidationError as err:
        return (_beyond(kind, value, at) or _placed(with_choices(str(err), kind), at),)
    return ()


def _beyond(kind: object, value: object, at: str) -> str:
    """Return the exceeded bounds of a number, in the console's words; empty if the fault is another."""
    found = inspect.type_info(kind)
    while isinstance(found, inspect.Metadata):
        found = found.type
    numbers = [one for one in getattr(found, "types", (found,)) if isinstance(one, inspect.IntType | inspect.FloatType)]
    if len(numbers) != 1 or isinstance(value, bool) or not isinstance(value, int | float):
        return ""
    (number,) = numbers
    if isinstance(number, inspect.IntType) and not isinstance(value, int):
        return ""
    bounds = {"above": number.gt, "at least": number.ge, "below": number.lt, "at most": number.le}
    said = " and ".join(f"{words} {bound:.12g}" for words, bound in bounds.items() if bound is not None)
    return f"{at.removeprefix('$.')} is {said}, not {value:.12g}" if said else ""


def _placed(text: str, at: str) -> str:
    """Return msgspec's objection to a part, with the path of that part."""
    said, found, path = text.partition(" - at `$")
    if found:
        return f"{said} - at `{at}{path}"
    return text if at == "$" else f"{text} - at `{at}`"
