"""The documents of an AWS IoT device shadow: bytes from the broker to what they say. Pure; whatever comes, it is an
answer or an InputError.

https://docs.aws.amazon.com/iot/latest/developerguide/device-shadow-document.html
"""

from typing import Any

import msgspec
from msgspec import Struct

from lbr.errors import InputError
from lbr.messages.unreadable import UNREADABLE, keyed_once

LARGEST_BYTES = 64 * 1024
"""A document has 8 kB, and its metadata is some times as long."""
MOST_VERSION = 2**53


class Document(Struct, frozen=True, kw_only=True):
    """A shadow as `get/accepted` tells it. `ask` is what is desired of the key `ask`, and `age_s` for how long it has
    been, by the service's own clock; None is not told."""

    version: int
    reported: dict[str, Any]
    ask: Any = None
    age_s: float | None = None


class Answer(Struct, frozen=True, kw_only=True):
    """The answer of the service to an update or a get: `token` is that of the request, `code` the reason of a
    rejection."""

    token: str = ""
    version: int | None = None
    code: int = 0
    text: str = ""


def read(payload: bytes) -> dict[str, Any]:
    """Return a JSON object."""
    if len(payload) > LARGEST_BYTES:
        raise InputError(f"it has {len(payload)} bytes, and a document {LARGEST_BYTES} at most", "malformed")
    try:
        found = msgspec.json.decode(keyed_once(payload))
    except RecursionError as err:
        raise InputError("its JSON is too deep", "malformed") from err
    except UNREADABLE as err:
        raise InputError(f"it is no JSON ({err})", "malformed") from err
    return _object(found, "it")


def version_of(said: dict[str, Any]) -> int:
    """Return a document's version."""
    found = said.get("version")
    if type(found) is not int or not 0 <= found <= MOST_VERSION:
        raise InputError("its version is no count", "malformed")
    return found


def document(said: dict[str, Any]) -> Document:
    """Return what `get/accepted` tells."""
    state = _object(said.get("state") or {}, "state")
    desired = _object(state.get("desired") or {}, "state.desired")
    reported = _object(state.get("reported") or {}, "state.reported")
    return Document(
        version=version_of(said),
        reported=reported,
        ask=desired.get("ask"),
        age_s=_age_s(said) if "ask" in desired else None,
    )


def answer(said: dict[str, Any]) -> Answer:
    """Return what `update/accepted`, `update/rejected` or `get/rejected` says."""
    token, code, text = said.get("clientToken"), said.get("code"), said.get("message")
    return Answer(
        token=token if isinstance(token, str) else "",
        version=version_of(said) if "version" in said else None,
        code=code if type(code) is int else 0,
        text=text[:200] if isinstance(text, str) else "",
    )


def _object(value: Any, what: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise InputError(f"{what} is no JSON object", "malformed")
    return value


def _age_s(said: dict[str, Any]) -> float | None:
    """Return for how long the newest part of what is asked has been there: both times are the service's."""
    metadata = said.get("metadata")
    desired = metadata.get("desired") if isinstance(metadata, dict) else None
    stamps = list(_stamps(desired.get("ask") if isinstance(desired, dict) else None))
    sent = said.get("timestamp")
    if sent is None or not stamps or not _is_time(sent):
        return None
    return float(max(0, sent - max(stamps)))


def _stamps(metadata: Any) -> list[float]:
    """Return all times in metadata, however deep: the reader of JSON has bounded that."""
    found, waiting = [], [metadata]
    while waiting:
        one = waiting.pop()
        if isinstance(one, dict):
            waiting += [value for name, value in one.items() if name != "timestamp" or isinstance(value, dict)]
            if _is_time(one.get("timestamp")):
                found.append(one["timestamp"])
        elif isinstance(one, list):
            waiting += one
    return found


def _is_time(value: Any) -> bool:
    return type(value) in (int, float) and 0 <= value < 2**40
