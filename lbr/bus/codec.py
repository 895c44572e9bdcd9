"""Bytes from outside become messages, or a MalformedError: whatever they are, nothing else is raised."""

from typing import Any, Generic, TypeVar

import msgspec

from lbr.errors import MalformedError

T = TypeVar("T")


class Decoder(Generic[T]):
    """Decodes the JSON of one message type."""

    def __init__(self, kind: type[T]) -> None:
        self._decoder = msgspec.json.Decoder(kind)

    def decode(self, data: bytes) -> T:
        """Return the message; raise MalformedError saying in one line what is wrong."""
        try:
            return self._decoder.decode(data)
        except msgspec.ValidationError as err:
            raise MalformedError(str(err)) from err
        except (msgspec.DecodeError, UnicodeDecodeError) as err:
            raise MalformedError(f"not JSON: {err}") from err
        except (RecursionError, OverflowError) as err:
            raise MalformedError(f"not sensible: {err}") from err


def decode(data: bytes) -> Any:
    """Return any JSON as plain data; raise MalformedError."""
    return _anything.decode(data)


_anything: Decoder[Any] = Decoder(Any)
