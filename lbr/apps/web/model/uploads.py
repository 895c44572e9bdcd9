"""The uploads of pages, in parts, as a request's body is small: packed by gzip, and unpacked within bounds."""

import zlib
from collections.abc import Callable

from msgspec import Struct

from lbr.apps.web.face import Refused

MOST_PACKED = 2 << 20
MOST_BYTES = 4 << 20
"""The most bytes when unpacked: those of the largest motion file."""
MOST_UPLOADS = 4
KEPT_S = 60.0
_GZIP = 31


class _Upload(Struct):
    """The received parts, and the time of the last one."""

    packed: bytes
    parts: int
    at: float


class Uploads:
    """All uploads, for the loop. An upload is known by its sender and a name of the sender's choice."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._uploads: dict[tuple[str, str], _Upload] = {}

    def add(self, who: str, name: str, part: int, packed: bytes) -> int:
        """Add a part, counted from 0; the first begins an upload. Return the size so far; raise Refused beyond the
        bounds."""
        self._tidy()
        key = who, name
        if part == 0:
            self._uploads.pop(key, None)
            if len(self._uploads) >= MOST_UPLOADS:
                raise Refused(503, "too much is sent at once: try again in a moment", {"Retry-After": "2"}, "busy")
            self._uploads[key] = _Upload(b"", 0, self._clock())
        upload = self._uploads.get(key)
        if upload is None or upload.parts != part:
            raise Refused(409, f"part {part} does not follow what came: begin with part 0", code="bad_value")
        if len(upload.packed) + len(packed) > MOST_PACKED:
            del self._uploads[key]
            raise Refused(413, f"packed it may have {MOST_PACKED} bytes")
        upload.packed += packed
        upload.parts += 1
        upload.at = self._clock()
        return len(upload.packed)

    def take(self, who: str, name: str) -> bytes:
        """Return and remove an upload, unpacked; raise Refused if it is unknown or malformed."""
        self._tidy()
        upload = self._uploads.pop((who, name), None)
        if upload is None:
            raise Refused(409, "what this is about was not sent, or too long ago: send it again", code="unknown_name")
        unpacking = zlib.decompressobj(_GZIP)
        try:
            content = unpacking.decompress(upload.packed, MOST_BYTES + 1)
        except zlib.error as err:
            raise Refused(400, f"it is not packed by gzip: {err}") from None
        if len(content) > MOST_BYTES:
            raise Refused(413, f"it has more than {MOST_BYTES} bytes, and no motion needs as many")
        if not unpacking.eof:
            raise Refused(400, "it ends in the middle: a part is missing")
        return content

    def _tidy(self) -> None:
        old = self._clock() - KEPT_S
        self._uploads = {key: one for key, one in self._uploads.items() if one.at >= old}
