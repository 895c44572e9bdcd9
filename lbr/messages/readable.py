"""A message for people: each value with the unit in its field's name, without empty values. Pure."""

from collections.abc import Mapping, Sequence
from typing import Any

UNITS = {
    "a": "A", "c": "°C", "deg": "°", "dps": "°/s", "hz": "Hz", "m": "m", "mb": "MB", "mps": "m/s", "mps2": "m/s²",
    "ms": "ms", "ns": "ns", "percent": "%", "px": "px", "rad": "rad", "rps": "rad/s", "s": "s", "ut": "µT", "v": "V",
}  # fmt: skip
"""By the last part of a field's name."""
TIGHT = frozenset({"°", "%"})
"""Units that follow their number without a space."""
LONGEST = 400
WHOLE = (1e3, 1e9)
"""Between these, a number is shown without a fraction."""
EMPTY: tuple[object, ...] = ("", [], {}, ())


def fields(message: Mapping[str, object]) -> str:
    """Return the fields of a message, such as `forward 2.61 m, charging yes`, and its age last, in parentheses."""
    shown = [_field(name, value) for name, value in message.items() if name != "age_s" and value not in EMPTY]
    age = message.get("age_s")
    old = f"  ({_number(age)} s old)" if isinstance(age, int | float) and not isinstance(age, bool) else ""
    return f"{', '.join(shown) or 'nothing'}{old}"


def _field(name: str, value: object) -> str:
    words, _, suffix = name.rpartition("_")
    unit = UNITS.get(suffix, "") if words else ""
    return f"{(words if unit else name).replace('_', ' ')} {_value(value, unit)}"


def _value(value: object, unit: str) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, Mapping):
        filled = {name: entry for name, entry in value.items() if entry not in EMPTY}
        inner = (f"{name} {_value(entry, unit)}" if unit else _field(name, entry) for name, entry in filled.items())
        return _bounded(f"({', '.join(inner)})", value)
    if isinstance(value, Sequence):
        if value and all(isinstance(item, int | float) for item in value):
            return _bounded(_with(f"[{' '.join(map(_number, value))}]", unit), value)
        return _bounded(", ".join(_value(item, unit) for item in value), value)
    return (
        _with(_number(value), unit) if isinstance(value, int | float) and not isinstance(value, bool) else _word(value)
    )


def _word(value: Any) -> str:
    return {None: "unknown", True: "yes", False: "no"}.get(value, str(value))


def _with(text: str, unit: str) -> str:
    return text + (unit if unit in TIGHT or not unit else f" {unit}")


def _number(value: float) -> str:
    if isinstance(value, int):
        return str(value)
    return f"{value:.0f}" if WHOLE[0] <= abs(value) < WHOLE[1] else f"{value or 0.0:.3g}"


def _bounded(text: str, value: Sequence[object] | Mapping[str, object]) -> str:
    """Return a text, or the number of its items if it would fill a screen."""
    return text if len(text) <= LONGEST else f"({len(value)} entries)"
