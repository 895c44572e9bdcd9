"""The meaning of the controller's answers, in SI units; None replaces every value that was not understood."""

import re
from typing import get_args

from lbr.drivers.roboteq import FaultName

FAULT_BITS: tuple[str, ...] = get_args(FaultName)
"""Names of the bits in the answer to `?FF`, from the lowest."""


def volts(text: str) -> tuple[float | None, float | None, float | None]:
    """Return the answer to `?V`: the controller's own supply, the battery, and the 5 V output."""
    numbers = _numbers(text)
    if len(numbers) != 3:
        return None, None, None
    internal, battery, output = numbers
    return _scaled(internal, 0.1, _SUPPLY_V), _scaled(battery, 0.1, _SUPPLY_V), _scaled(output, 0.001, _OUTPUT_V)


def amps(text: str) -> tuple[float | None, ...]:
    """Return the answer to `?A`: signed amperes of each channel."""
    return tuple(_scaled(number, 0.1, _MOTOR_A) for number in _numbers(text))


def counts(text: str) -> tuple[int | None, ...]:
    """Return the answer to `?C`: a whole number for each channel."""
    return tuple(n if n is not None and -(2**31) <= n < 2**31 else None for n in _numbers(text))


def hottest_c(text: str) -> float | None:
    """Return the highest temperature in the answer to `?T`: the processor, then the heat sink of each channel."""
    temperatures = (_scaled(number, 1.0, _HEAT_C) for number in _numbers(text))
    return max((celsius for celsius in temperatures if celsius is not None), default=None)


def faults(text: str) -> tuple[str, ...] | None:
    """Return the names of the set bits in the answer to `?FF`; None if it was not understood."""
    numbers = _numbers(text)
    if len(numbers) != 1 or numbers[0] is None or numbers[0] < 0:
        return None
    mask = numbers[0]
    named = tuple(name for bit, name in enumerate(FAULT_BITS) if mask >> bit & 1)
    unnamed = tuple(f"bit_{bit}" for bit in range(len(FAULT_BITS), mask.bit_length()) if mask >> bit & 1)
    return named + unnamed


def setting(text: str) -> int | None:
    """Return a setting, the answer to `~RWD` or `~MXMD`; with a value for each channel, only if all agree."""
    numbers = set(_numbers(text))
    return numbers.pop() if len(numbers) == 1 else None


def _numbers(text: str) -> tuple[int | None, ...]:
    return tuple(int(field) if _INTEGER.fullmatch(field) else None for field in text.strip().split(":"))


def _scaled(number: int | None, unit: float, bounds: tuple[float, float]) -> float | None:
    """Scale a number; None if no controller of this family can measure it, so that it is a misread digit."""
    value = None if number is None else round(number * unit, 4)
    return value if value is not None and bounds[0] <= value <= bounds[1] else None


_SUPPLY_V, _OUTPUT_V = (0.0, 65.0), (0.0, 10.0)
_MOTOR_A, _HEAT_C = (-300.0, 300.0), (-50.0, 150.0)
_INTEGER = re.compile(r"[+-]?[0-9]{1,10}")
