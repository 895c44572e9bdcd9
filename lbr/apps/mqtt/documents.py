"""Reads the documents of an AWS IoT device shadow. Pure: any bytes become an answer or an InputError.

https://docs.aws.amazon.com/iot/latest/developerguide/device-shadow-document.html
"""

from typing import TypeGuard

import msgspec
from msgspec import Struct

from lbr.errors import InputError
from lbr.messages.unreadable import UNREADABLE, keyed_once

LARGEST_BYTES = 64 * 1024
"""A document has 8 kB, and its metadata is several times as long."""
MOST_VERSION = 2**53


class Document(Struct, frozen=True, kw_only=True):
    """A shadow in `get/accepted`. `ask` is the desired value of the key `ask`.

    `age_s` is the age of that value by the service's own clock; None if unknown.
    """

    version: int
    reported: dict[str, object]
    ask: object = None
    age_s: float | None = None


class Answer(Struct, frozen=True, kw_only=True):
    """The service's answer to an update or get: `token` is the request's, `code` the reason of a rejection."""

    token: str = ""
    version: int | None = None
    code: int = 0
    text: str = ""


def read(payload: bytes) -> dict[str, object]:
    """Decode a JSON object."""
    if len(payload) > LARGEST_BYTES:
        raise InputError(f"it has {len(payload)} bytes, and a document {LARGEST_BYTES} at most", "malformed")
    try:
        content = msgspec.json.decode(keyed_once(payload))
    except RecursionError as err:
        raise InputError("its JSON is too deep", "malformed") from err
    except UNREADABLE as err:
        raise InputError(f"it is no JSON ({err})", "malformed") from err
    return _object(content, "it")


def version_of(fields: dict[str, object]) -> int:
    """Return a document's version."""
    version = fields.get("version")
    if type(version) is not int or not 0 <= version <= MOST_VERSION:
        raise InputError("its version is no count", "malformed")
    return version


def document(fields: dict[str, object]) -> Document:
    """Return the document in `get/accepted`."""
    state = _object(fields.get("state") or {}, "state")
    desired = _object(state.get("desired") or {}, "state.desired")
    reported = _object(state.get("reported") or {}, "state.reported")
    return Document(
        version=version_of(fields),
        reported=reported,
        ask=desired.get("ask"),
        age_s=_age_s(fields) if "ask" in desired else None,
    )


def answer(fields: dict[str, object]) -> Answer:
    """Return the answer in `update/accepted`, `update/rejected` or `get/rejected`."""
    token, code, text = fields.get("clientToken"), fields.get("code"), fields.get("message")
    return Answer(
        token=token if isinstance(token, str) else "",
        version=version_of(fields) if "version" in fields else None,
        code=code if type(code) is int else 0,
        text=text[:200] if isinstance(text, str) else "",
    )


def _object(value: object, what: str) -> dict[str, object]:
    if not isinstance(value, dict):
        raise InputError(f"{what} is no JSON object", "malformed")
    return value


def _age_s(fields: dict[str, object]) -> float | None:
    """Return the age of the newest part of a desire; both times are the service's."""
    metadata = fields.get("metadata")
    desired = metadata.get("desired") if isinstance(metadata, dict) else None
    stamps = list(_stamps(desired.get("ask") if isinstance(desired, dict) else None))
    sent = fields.get("timestamp")
    if sent is None or not stamps or not _is_time(sent):
        return None
    return float(max(0, sent - max(stamps)))


def _stamps(metadata: object) -> list[float]:
    """Return all times in metadata, at any depth, which the JSON decoder has bounded."""
    stamps, waiting = [], [metadata]
    while waiting:
        part = waiting.pop()
        if isinstance(part, dict):
            waiting += [value for name, value in part.items() if name != "timestamp" or isinstance(value, dict)]
            if _is_time(stamp := part.get("timestamp")):
                stamps.append(stamp)
        elif isinstance(part, list):
            waiting += part
    return stamps


def _is_time(value: object) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value < 2**40
