"""Pictures on a stream socket: requests are lines of JSON, pictures are records. Pure.

A record: u32 length of the JPEG, u64 CLOCK_MONOTONIC in ns when it was taken, both little endian, then the JPEG.
"""

import struct

import msgspec

from lbr.errors import MalformedError

_HEADER = struct.Struct("<IQ")
LARGEST_BYTES = 8 << 20
"""The limit for a picture: a longer one means that the two ends are out of step."""


def request(**wanted: object) -> bytes:
    """Return a line that asks for pictures, or sets controls."""
    return msgspec.json.encode(wanted) + b"\n"


class RecordParser:
    """Turns bytes, in pieces of any size, into pictures; holds no more than one unfinished picture."""

    def __init__(self) -> None:
        self._held = bytearray()

    def feed(self, data: bytes) -> list[tuple[bytes, int]]:
        """Return the pictures that these bytes complete, each with its time in ns; raise MalformedError."""
        self._held += data
        pictures = []
        while len(self._held) >= _HEADER.size:
            length, taken_ns = _HEADER.unpack_from(self._held)
            if not 0 < length <= LARGEST_BYTES:
                raise MalformedError(f"a picture of {length} bytes was announced")
            end = _HEADER.size + length
            if len(self._held) < end:
                break
            pictures.append((bytes(self._held[_HEADER.size : end]), taken_ns))
            del self._held[:end]
        return pictures
