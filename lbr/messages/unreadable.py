"""Errors of bytes that are not a message, and of JSON that contradicts itself."""

import json
from contextlib import suppress

import msgspec

UNREADABLE = (msgspec.MsgspecError, UnicodeDecodeError, RecursionError)
"""From decoding JSON: it is not JSON, not of that type, holds bytes that are not text, or is nested too deeply."""


def keyed_once(data: bytes) -> bytes:
    """Return the same JSON; raise ValidationError if an object has a key twice, as decoders silently use the last
    one."""
    with suppress(json.JSONDecodeError, UnicodeDecodeError):  # the decoder reports invalid JSON
        json.loads(data, object_pairs_hook=_once_each, parse_int=str, parse_float=str, parse_constant=str)
    return data


def _once_each(pairs: list[tuple[str, object]]) -> None:
    names = [name for name, _ in pairs]
    if len(set(names)) < len(names):
        repeated = next(name for name in names if names.count(name) > 1)
        raise msgspec.ValidationError(f"the key '{repeated[:40]}' stands twice in one object")
