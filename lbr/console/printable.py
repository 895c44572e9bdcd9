"""The characters of a line, and the display of a value to the person who typed it."""

import re
import textwrap
import unicodedata

from lbr.errors import InputError
from lbr.messages.plain import one_line

MAX_LINE = 4096
BLANK = " \t\r\n\ufeff\u200b\u2060"
"""Invisible characters at a line's ends, from editors and web pages: the last three have no width."""
_REFUSED = frozenset({"Cc", "Cs", "Cn", "Zl", "Zp"})
_TURNERS = frozenset("\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")  # they reorder text


def clean(line: str | bytes) -> str:
    """Return a line without the blanks around it; raise InputError for a line that a person would not type."""
    if len(line) > MAX_LINE:
        raise InputError(f"the line is too long: {MAX_LINE} characters are allowed")
    if isinstance(line, bytes):
        try:
            line = line.decode()
        except UnicodeDecodeError:
            raise InputError("the line is not valid UTF-8; send text") from None
    line = line.strip(BLANK)
    for char in line:
        category = unicodedata.category(char)
        if category == "Cs":
            raise InputError("the line is not valid UTF-8; send text")
        if category in _REFUSED or char in _TURNERS:
            raise InputError(
                f"the line contains the control character U+{ord(char):04X}; one line of plain text is allowed"
            )
    return line.strip()


def bare(text: str, also: str = "") -> str:
    """Return a text without blanks, control characters, file marks and those of `also` at its ends."""
    begin, end = 0, len(text)
    while begin < end and _bare(text[begin], also):
        begin += 1
    while begin < end and _bare(text[end - 1], also):
        end -= 1
    return text[begin:end]


def _bare(char: str, also: str) -> bool:
    return char.isspace() or char in also or unicodedata.category(char) in {"Cc", "Cf"}


def wrapped(text: str, width: int) -> str:
    """Return a text with long lines broken at blanks; a line of two columns continues below its second column."""
    lines = []
    for line in text.splitlines():
        safe = one_line(line)
        column = re.match(r"\S.*?\s{2,}", safe)
        indent = " " * (column.end() if column and column.end() < width // 2 else 2)
        lines += textwrap.wrap(safe, max(width, 20), subsequent_indent=indent) or [""]
    return "\n".join(lines)


def listed(items: list[str], word: str = "or") -> str:
    """Return `a, b or c`."""
    return f" {word} ".join(filter(None, [", ".join(items[:-1]), items[-1]])) if items else "nothing"
