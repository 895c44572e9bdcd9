"""Decodes JSON from files and from the bus, which may be malformed. Pure."""

from typing import TypeVar

import msgspec

from lbr.messages.unreadable import UNREADABLE

T = TypeVar("T")


def read_or_none(data: bytes | str | msgspec.Raw | None, kind: type[T]) -> T | None:
    """Decode a message of this type; None without data, or if it is malformed."""
    try:
        return msgspec.json.decode(data, type=kind) if data is not None else None
    except UNREADABLE:
        return None
