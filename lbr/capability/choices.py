"""The allowed values of a type, for messages about a value that is not one of them."""

import re
from collections.abc import Iterator
from typing import Literal, get_args, get_origin

from lbr.names import did_you_mean

_NO_CHOICE = re.compile(r"""Invalid enum value (['"])(.*?)\1(?= - at `|\Z)""")


def with_choices(text: str, kind: object) -> str:
    """Return msgspec's objection to a value, with the type's nearest choices at that place."""
    match, names = _NO_CHOICE.search(text), tuple(_choices(kind))
    if match is None or not names:
        return text
    return f"{text[: match.end()]}, {did_you_mean(match[2], names)}{text[match.end() :]}"


def _choices(kind: object) -> Iterator[str]:
    for choice in get_args(kind):
        if get_origin(kind) is not Literal:
            yield from _choices(choice)
        elif isinstance(choice, str) and choice:
            yield choice
