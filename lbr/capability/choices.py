"""The allowed values of a type, for messages about a value that is not among them."""

import re
from collections.abc import Iterator
from typing import Literal, get_args, get_origin

from lbr.names import did_you_mean

_NO_CHOICE = re.compile(r"""Invalid enum value (['"])(.*?)\1(?= - at `|\Z)""")


def with_choices(said: str, kind: object) -> str:
    """Return msgspec's objection to a value, and the nearest of the type's choices at the place where it is not one of
    them."""
    found, names = _NO_CHOICE.search(said), tuple(_choices(kind))
    if found is None or not names:
        return said
    return f"{said[: found.end()]}, {did_you_mean(found[2], names)}{said[found.end() :]}"


def _choices(kind: object) -> Iterator[str]:
    for one in get_args(kind):
        if get_origin(kind) is not Literal:
            yield from _choices(one)
        elif isinstance(one, str) and one:
            yield one
