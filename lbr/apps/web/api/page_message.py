"""The messages of a page over the live socket. Pure: raises Rubbish for any other bytes, and nothing else."""

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
    """A motion that a page requests: its command, the command's message, and the page's number for it."""

    to: Annotated[str, Meta(pattern=f"^{NAME_LETTERS}/{NAME_LETTERS}$(?!\\n)", max_length=81)]
    message: dict[str, Any] = {}
    n: Number

    @property
    def capability(self) -> str:
        """Return the capability that moves."""
        return self.to.partition("/")[0]

    @property
    def command(self) -> str:
        """Return the command's name."""
        return self.to.partition("/")[2]


class PageMessage(Struct, frozen=True, kw_only=True):
    """A message of a page; each field is optional, and unknown fields are ignored.

    - `hear`: the page's streams from now on, at most `rate_hz` times a second.
    - `hold`: begins or changes motion; `keep` continues the motion with that number; `release` ends it.
    - `t`: the newest server time that the page received.
    """

    hear: Annotated[tuple[Key, ...], Meta(max_length=MOST_KEYS)] | UnsetType = UNSET
    rate_hz: Annotated[float, Meta(ge=0.2, le=FASTEST_HZ)] | UnsetType = UNSET
    hold: Wanted | UnsetType = UNSET
    keep: Number | UnsetType = UNSET
    release: bool | UnsetType = UNSET
    t: float | UnsetType = UNSET


class Rubbish(Exception):  # noqa: N818 - an answer, not a fault
    """Bytes that are not a valid message; the text names the faulty field."""


_decoder = msgspec.json.Decoder(PageMessage)
_OF_THE_SERVER = ("lease", "ttl_s")


def parse(data: bytes) -> PageMessage:
    """Parse a page's message; raise Rubbish.

    A held motion's lease and lifetime are dropped, as the server sets them.
    """
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
