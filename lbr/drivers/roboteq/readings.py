"""The meaning of the controller's answers, in SI units; None stands for one that was not understood, never a made-up
number."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import get_args

from lbr.drivers.roboteq import FaultName
from lbr.drivers.roboteq.protocol import Value

FAULT_BITS: tuple[str, ...] = get_args(FaultName)
"""Names of the bits that `?FF` answers with, from the lowest."""


@dataclass(frozen=True, slots=True)
class Volts:
    """Answer to `?V`: the controller's own supply, the battery, and the 5 V output."""

    internal_v: float | None
    battery_v: float | None
    output_v: float | None


@dataclass(frozen=True, slots=True)
class Channels:
    """One whole number for each channel, as `?C` answers."""

    values: tuple[int | None, ...]


@dataclass(frozen=True, slots=True)
class Amps:
    """Answer to `?A`: signed amperes for each channel."""

    amps_a: tuple[float | None, ...]


@dataclass(frozen=True, slots=True)
class Temperatures:
    """Answer to `?T`: the processor, then the heat sink of each channel."""

    celsius: tuple[float | None, ...]

    @property
    def hottest_c(self) -> float | None:
        """The highest of them."""
        return max((value for value in self.celsius if value is not None), default=None)


@dataclass(frozen=True, slots=True)
class Flags:
    """Names of the bits set, as `?FF` answers; None: not understood."""

    names: tuple[str, ...] | None


@dataclass(frozen=True, slots=True)
class Text:
    """Words, as `?FID` and `?TRN` answer."""

    text: str


@dataclass(frozen=True, slots=True)
class Setting:
    """The value of a setting, as `~RWD` or `~MXMD` answer."""

    value: int | None


Reading = Volts | Channels | Amps | Temperatures | Flags | Text | Setting


def decode(reply: Value) -> Reading:
    """Return what an answer means, by its name; a name without a meaning of its own is a setting."""
    return _DECODERS.get(reply.name, _setting)(reply.text)


def _volts(text: str) -> Volts:
    numbers = _numbers(text)
    if len(numbers) != 3:
        return Volts(None, None, None)
    internal, battery, output = numbers
    return Volts(_scaled(internal, 0.1, _SUPPLY_V), _scaled(battery, 0.1, _SUPPLY_V), _scaled(output, 0.001, _OUTPUT_V))


def _amps(text: str) -> Amps:
    return Amps(tuple(_scaled(number, 0.1, _MOTOR_A) for number in _numbers(text)))


def _temperatures(text: str) -> Temperatures:
    return Temperatures(tuple(_scaled(number, 1.0, _HEAT_C) for number in _numbers(text)))


def _channels(text: str) -> Channels:
    return Channels(tuple(n if n is not None and -(2**31) <= n < 2**31 else None for n in _numbers(text)))


def _faults(text: str) -> Flags:
    return Flags(_named(text, FAULT_BITS))


def _text(text: str) -> Text:
    return Text(text.strip())


def _setting(text: str) -> Setting:
    """A setting may answer once for each channel; then it counts only if all agree."""
    numbers = set(_numbers(text))
    return Setting(numbers.pop() if len(numbers) == 1 else None)


def _named(text: str, bits: tuple[str, ...]) -> tuple[str, ...] | None:
    numbers = _numbers(text)
    if len(numbers) != 1 or numbers[0] is None or numbers[0] < 0:
        return None
    mask = numbers[0]
    named = tuple(name for bit, name in enumerate(bits) if mask >> bit & 1)
    unnamed = tuple(f"bit_{bit}" for bit in range(len(bits), mask.bit_length()) if mask >> bit & 1)
    return named + unnamed


def _numbers(text: str) -> tuple[int | None, ...]:
    return tuple(int(field) if _INTEGER.fullmatch(field) else None for field in text.strip().split(":"))


def _scaled(number: int | None, unit: float, bounds: tuple[float, float]) -> float | None:
    """A value that no controller of this family can measure is a misread digit, and not measured."""
    value = None if number is None else round(number * unit, 4)
    return value if value is not None and bounds[0] <= value <= bounds[1] else None


_SUPPLY_V, _OUTPUT_V = (0.0, 65.0), (0.0, 10.0)
_MOTOR_A, _HEAT_C = (-300.0, 300.0), (-50.0, 150.0)
_INTEGER = re.compile(r"[+-]?[0-9]{1,10}")
_DECODERS: dict[str, Callable[[str], Reading]] = {
    "V": _volts,
    "A": _amps,
    "T": _temperatures,
    "C": _channels,
    "FF": _faults,
    "FID": _text,
    "TRN": _text,
}
