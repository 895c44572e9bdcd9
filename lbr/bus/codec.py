"""Bytes from outside become messages, or raise MalformedError and nothing else."""

from typing import Any, Generic, TypeVar

import msgspec

from lbr.bus import pictures
from lbr.errors import MalformedError
from lbr.messages.camera import JpegFrame
from lbr.messages.in_words import in_words
from lbr.messages.unreadable import UNREADABLE, keyed_once

T = TypeVar("T")
LONGEST = 200
"""The longest report about an unreadable message; it appears on every console."""


class Decoder(Generic[T]):
    """Decodes the JSON of one message type. In a command, which requests something, no key may occur twice."""

    def __init__(self, kind: type[T], *, command: bool = False) -> None:
        self._decoder = msgspec.json.Decoder(kind)
        self._command = command

    def decode(self, data: bytes) -> T:
        """Return the message; MalformedError names the fault in one line."""
        try:
            return self._decoder.decode(keyed_once(data) if self._command else data)
        except msgspec.ValidationError as err:
            raise MalformedError(_bounded(in_words(str(err)))) from err
        except RecursionError as err:
            raise MalformedError("the JSON is nested too deeply") from err
        except OverflowError as err:
            raise MalformedError(f"not sensible: {err}") from err
        except UNREADABLE as err:
            raise MalformedError(f"not JSON: {err}") from err


def _bounded(text: str) -> str:
    """Shorten a long quoted value: the expected type stands before it, and the field behind it."""
    return text if len(text) <= LONGEST else f"{text[: LONGEST // 2]}…{text[-LONGEST // 2 :]}"


class PictureDecoder:
    """Accepts the bytes of a JPEG file unchanged, if they begin and end like one."""

    def decode(self, data: bytes) -> JpegFrame:
        """Return the picture; raise MalformedError if it is not one."""
        if not pictures.is_whole(data):
            raise MalformedError(f"not a whole JPEG picture ({len(data)} bytes)")
        return JpegFrame(data)


def decode(data: bytes) -> Any:
    """Return any JSON as plain data; raise MalformedError."""
    return _anything.decode(data)


def decode_request(data: bytes) -> object:
    """Return a request, any JSON, as plain data; raise MalformedError."""
    return _request.decode(data)


_anything: Decoder[object] = Decoder(Any)
_request: Decoder[object] = Decoder(Any, command=True)
