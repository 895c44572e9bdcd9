"""The messages of a page over the live socket. Pure: bytes from outside become a message, or Rubbish; nothing else is
raised."""

from typing import Annotated, Any

import msgspec
from msgspec import UNSET, Meta, Struct, UnsetType

from lbr.apps.web.routing import plain
from lbr.messages.units import NAME_LETTERS
from lbr.messages.unreadable import keyed_once

LARGEST = 16 * 1024
MOST_KEYS = 64
FASTEST_HZ = 50.0
USUAL_HZ = 25.0

Number = Annotated[int, Meta(ge=0, le=2**53)]
Key = Annotated[str, Meta(max_length=100)]


class Wanted(Struct, frozen=True, kw_only=True):
    """Motion that a page wants: the command that it is asked by, its message, and the page's number for it."""

    to: Annotated[str, Meta(pattern=f"^{NAME_LETTERS}/{NAME_LETTERS}$(?!\\n)", max_length=81)]
    message: dict[str, Any] = {}
    n: Number

    @property
    def capability(self) -> str:
        """Return the capability that is to move."""
        return self.to.partition("/")[0]

    @property
    def command(self) -> str:
        """Return the command that it is asked by."""
        return self.to.partition("/")[2]


class PageMessage(Struct, frozen=True, kw_only=True):
    """A message of a page; fields that are not there say nothing, and those that are not known mean nothing.

    `hear` are the streams that it wants from now on, `rate_hz` times a second at most. `hold` begins or changes motion,
    `keep` goes on with what has that number, `release` ends it. `t` is the newest time of the server's that it heard.
    """

    hear: Annotated[tuple[Key, ...], Meta(max_length=MOST_KEYS)] | UnsetType = UNSET
    rate_hz: Annotated[float, Meta(ge=0.2, le=FASTEST_HZ)] | UnsetType = UNSET
    hold: Wanted | UnsetType = UNSET
    keep: Number | UnsetType = UNSET
    release: bool | UnsetType = UNSET
    t: float | UnsetType = UNSET


class Rubbish(Exception):  # noqa: N818 - an answer, not a fault
    """The bytes are not a message; the text names the place where they do not fit."""


_decoder = msgspec.json.Decoder(PageMessage)
_OF_THE_SERVER = ("lease", "ttl_s")


def parse(data: bytes) -> PageMessage:
    """Return what a page says; raise Rubbish. Of held motion, lease and lifetime are the server's own business."""
    if len(data) > LARGEST:
        raise Rubbish(f"a message may have {LARGEST} bytes")
    try:
        parsed = _decoder.decode(keyed_once(data))
        if parsed.hold is UNSET:
            return parsed
        message = {name: value for name, value in parsed.hold.message.items() if name not in _OF_THE_SERVER}
        msgspec.json.encode(message)
        return msgspec.structs.replace(parsed, hold=msgspec.structs.replace(parsed.hold, message=message))
    except RecursionError:
        raise Rubbish("the JSON is nested too deeply") from None
    except (msgspec.MsgspecError, ValueError, OverflowError) as err:  # a UnicodeDecodeError is a ValueError
        raise Rubbish(plain(err)[:200]) from None
