"""The permitted arguments after the name of an external command."""

import re
import subprocess
import sys
from collections.abc import Sequence

Argument = Sequence[str] | str
"""The permitted words, or a regular expression for the whole argument."""
MOST = 16
LONGEST = 200
"""Of an argument and of a pattern: room for a path."""
COMPARED_WITHIN_S = 5.0
"""A process of its own takes some 20 ms, and up to a second on a very busy machine."""
_FITS = 10
_COMPARE = f"""
import os, resource, re, sys
os.nice(39)
resource.setrlimit(resource.RLIMIT_CPU, (1, 1))
sys.exit({_FITS} if re.fullmatch(sys.argv[1], sys.argv[2], re.ASCII) else 0)
"""


def fault(allowed: Sequence[object]) -> str:
    """Return the fault in the column `arguments` as decoded JSON, or an empty text."""
    if len(allowed) > MOST:
        return f"allows more than {MOST} arguments"
    return next((text for number, one in enumerate(allowed, start=1) if (text := _fault(number, one))), "")


def refusal(allowed: Sequence[Argument], given: Sequence[str]) -> str:
    """Return why arguments are refused, as the end of a sentence; empty if they are not."""
    if len(given) > len(allowed):
        most = f"at most {len(allowed)} argument{'' if len(allowed) == 1 else 's'}" if allowed else "no arguments"
        return f"takes {most}"
    for number, (one, word) in enumerate(zip(allowed, given, strict=False), start=1):
        if not _takes(one, word):
            return f"takes as its {_ordinal(number)} argument {described(one)}, not '{_shortened(word)}'"
    return ""


def described(argument: Argument) -> str:
    """Return the values that an argument may have, for people."""
    return f"what fits {argument}" if isinstance(argument, str) else " or ".join(argument)


def _takes(argument: Argument, word: str) -> bool:
    """Return whether a word fits an argument. A word that a program may read as an option must be listed in the row."""
    if not isinstance(argument, str):
        return word in argument
    if word.startswith("-") or len(word) > LONGEST or not word.isprintable():
        return False
    return _fits(argument, word)


def _fits(pattern: str, word: str) -> bool:
    """Return whether a pattern fits a whole word; one that takes too long does not.

    Python compares with its lock held, and may need forever for one short word. So another process does it, which the
    kernel ends after a second of computing. It has the lowest rank, as typing must not slow the robot.
    """
    try:
        done = subprocess.run(
            [sys.executable, "-I", "-S", "-c", _COMPARE, pattern, word],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            timeout=COMPARED_WITHIN_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == _FITS


def _fault(number: int, entry: object) -> str:
    if isinstance(entry, list) and entry and all(_is_word(word) for word in entry):
        return ""
    if not isinstance(entry, str) or not _is_word(entry):
        return f'entry {number} is neither a list of words, such as ["left", "right"], nor a regular expression'
    try:
        re.compile(entry, re.ASCII)
    except (re.error, OverflowError, RecursionError) as err:
        return f"entry {number} is not a regular expression: {err}"
    return ""


def _is_word(word: object) -> bool:
    return isinstance(word, str) and 0 < len(word) <= LONGEST and word.isprintable()


def _ordinal(number: int) -> str:
    return {1: "first", 2: "second", 3: "third"}.get(number, f"{number}th")


def _shortened(word: str) -> str:
    return "".join(c if c.isprintable() else "?" for c in word[:40]) + ("…" if len(word) > 40 else "")
