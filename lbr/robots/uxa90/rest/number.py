"""Numbers as JavaScript reads and writes them: phones and scripts were made for a server in that language."""

import re
from math import copysign, floor, inf, isfinite, isinf, isnan, nan

WHITESPACE = (
    "\t\n\v\f\r \u00a0\u1680"
    "\u2000\u2001\u2002\u2003\u2004\u2005\u2006\u2007\u2008\u2009\u200a\u2028\u2029\u202f\u205f\u3000\ufeff"
)
LONGEST = 400
"""The most characters of a number; longer ones are mistakes, and take ever longer to read."""
LARGEST_BITS = 1023
_DECIMAL = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_PREFIXED = re.compile(r"0(?:[xX][0-9a-fA-F]+|[oO][0-7]+|[bB][01]+)")
_INTEGER = re.compile(r"[+-]?(?:0[xX][0-9a-fA-F]|[0-9])")


def number(text: str) -> float:
    """Return the result of `Number(text)`: empty is 0, junk NaN; decimal, 0x, 0o, 0b and Infinity are numbers."""
    text = text.strip(WHITESPACE)
    if not text:
        return 0.0
    if len(text) > LONGEST:
        return nan
    if _DECIMAL.fullmatch(text):
        return float(text)
    if _PREFIXED.fullmatch(text):
        whole = int(text, 0)
        return float(whole) if whole.bit_length() <= LARGEST_BITS else inf
    return {"Infinity": inf, "+Infinity": inf, "-Infinity": -inf}.get(text, nan)


def of_json(value: float) -> float:
    """Return a number of a JSON body; a whole one larger than any float becomes infinite."""
    try:
        return float(value)
    except OverflowError:
        return inf if value > 0 else -inf


def begins_as_integer(text: str) -> bool:
    """Return whether `parseInt(text)` is a number: it reads only the beginning."""
    return _INTEGER.match(text.lstrip(WHITESPACE)) is not None


def plain(value: float) -> int | float:
    """Return a number as written in JSON: whole ones without a point."""
    return int(value) if isfinite(value) and value == floor(value) and abs(value) < 1e21 else value


def written(value: float) -> str:
    """Return the result of `String(value)`."""
    if isnan(value):
        return "NaN"
    if isinf(value):
        return "Infinity" if value > 0 else "-Infinity"
    if value == floor(value) and abs(value) < 1e21:
        return str(int(value))
    sign = "-" if copysign(1.0, value) < 0 else ""
    digits, point = _shortest(abs(value))
    if -6 < point <= 0:
        return f"{sign}0.{'0' * -point}{digits}"
    if 0 < point < len(digits):
        return f"{sign}{digits[:point]}.{digits[point:]}"
    exponent = point - 1
    mantissa = digits[0] + (f".{digits[1:]}" if len(digits) > 1 else "")
    return f"{sign}{mantissa}e{'+' if exponent > 0 else '-'}{abs(exponent)}"


def nearest(value: float) -> int:
    """Return the nearest count; halves go up."""
    return floor(value + 0.5)


def clamped(value: float, lowest: float, highest: float) -> float:
    """Return a number within bounds."""
    return min(max(value, lowest), highest)


def _shortest(value: float) -> tuple[str, int]:
    """Return the fewest digits of this number, and the place of its point: 0.digits times ten to that power."""
    mantissa, _, exponent = f"{value!r}".partition("e")
    whole, _, part = mantissa.partition(".")
    digits = (whole + part).lstrip("0")
    leading = len(whole + part) - len(digits)
    return digits.rstrip("0"), len(whole) - leading + int(exponent or 0)
