"""Suggests which name may have been meant."""

import difflib
import re
from collections.abc import Iterable, Iterator
from typing import Any, Literal, get_args, get_origin

MOST_TOLD = 8
_NO_CHOICE = re.compile(r"""Invalid enum value (['"])(.*?)\1(?= - at `|\Z)""")


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return which of the known names may have been meant, or which there are."""
    names = sorted(set(known))
    if not names:
        return "there is none"
    close = difflib.get_close_matches(name[:64], names, n=3, cutoff=0.5)
    if close:
        return f"did you mean {' or '.join(close)}?"
    more = ", …" if len(names) > MOST_TOLD else ""
    return f"there {'is' if len(names) == 1 else 'are'} {', '.join(names[:MOST_TOLD])}{more}"


def with_choices(said: str, kind: Any) -> str:
    """Return what msgspec says against a value, and where it is none of a type's choices, which may have been meant."""
    found, names = _NO_CHOICE.search(said), tuple(_choices(kind))
    if found is None or not names:
        return said
    return f"{said[: found.end()]}, {did_you_mean(found[2], names)}{said[found.end() :]}"


def _choices(kind: Any) -> Iterator[str]:
    for one in get_args(kind):
        if get_origin(kind) is not Literal:
            yield from _choices(one)
        elif isinstance(one, str) and one:
            yield one
