"""USB/IP as the kernel speaks it to the other end of an attached socket: 48-byte heads, big endian, and what follows.

Written from the kernel's `Documentation/usb/usbip_protocol.rst`. Isochronous transfers are not spoken.
"""

import struct
from dataclasses import dataclass

HEAD_BYTES = 48
CMD_SUBMIT, CMD_UNLINK, RET_SUBMIT, RET_UNLINK = 1, 2, 3, 4
MOST_BYTES = 1 << 20
"""No driver here asks for more at once; what does has lost the place where a head begins."""

_BASIC = struct.Struct(">5I")
_SUBMIT = struct.Struct(">I4i8s")
_UNLINK = struct.Struct(">I24x")
_RETURN = struct.Struct(">5i8x")
_SETUP = struct.Struct("<BBHHH")


class FramingError(ValueError):
    """What came is no head; where the next one begins cannot be known."""


@dataclass(frozen=True, slots=True)
class Setup:
    """The eight bytes that begin a control transfer."""

    type: int
    request: int
    value: int
    index: int
    length: int

    @classmethod
    def of(cls, data: bytes) -> "Setup":
        return cls(*_SETUP.unpack(data))

    def encoded(self) -> bytes:
        return _SETUP.pack(self.type, self.request, self.value, self.index, self.length)


@dataclass(frozen=True, slots=True)
class Submit:
    """A transfer that the kernel wants: `data` if it goes out, `length` bytes of room if it comes in."""

    number: int
    device: int
    into_host: bool
    endpoint: int
    length: int
    setup: Setup
    data: bytes = b""


@dataclass(frozen=True, slots=True)
class Unlink:
    """A transfer that the kernel no longer wants."""

    number: int
    device: int
    wanted: int


class Reader:
    """Cuts what the kernel sends into requests, however it is chopped."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    def feed(self, data: bytes) -> list[Submit | Unlink]:
        """Return the requests that are now complete; raise FramingError on what can be none."""
        self._buffer += data
        found: list[Submit | Unlink] = []
        while (one := self._next()) is not None:
            found.append(one)
        return found

    def _next(self) -> Submit | Unlink | None:
        if len(self._buffer) < HEAD_BYTES:
            return None
        command, number, device, direction, endpoint = _BASIC.unpack_from(self._buffer)
        if command == CMD_UNLINK:
            (wanted,) = _UNLINK.unpack_from(self._buffer, _BASIC.size)
            del self._buffer[:HEAD_BYTES]
            return Unlink(number, device, wanted)
        if command != CMD_SUBMIT or direction > 1 or endpoint > 15:
            raise FramingError(f"no request: command {command}, direction {direction}, endpoint {endpoint}")
        _flags, length, _start, packets, _interval, setup = _SUBMIT.unpack_from(self._buffer, _BASIC.size)
        if not 0 <= length <= MOST_BYTES or packets not in {0, -1}:
            raise FramingError(f"no request: {length} bytes, {packets} isochronous packets")
        end = HEAD_BYTES + (0 if direction else length)
        if len(self._buffer) < end:
            return None
        data = bytes(self._buffer[HEAD_BYTES:end])
        del self._buffer[:end]
        return Submit(number, device, bool(direction), endpoint, length, Setup.of(setup), data)


def submitted(number: int, status: int, *, actual: int, data: bytes = b"") -> bytes:
    """Return the answer to a transfer: 0 or a negative errno, how many bytes went, and those that came in."""
    return _BASIC.pack(RET_SUBMIT, number, 0, 0, 0) + _RETURN.pack(status, actual, 0, 0, 0) + data


def unlinked(number: int, status: int) -> bytes:
    """Return the answer to an unlink: -ECONNRESET if the transfer was still open, 0 if it was answered before."""
    return _BASIC.pack(RET_UNLINK, number, 0, 0, 0) + _RETURN.pack(status, 0, 0, 0, 0)
