"""A USB camera, UVC 1.1, that sends MJPEG over a bulk endpoint: `/dev/videoN`."""

import struct
import time
from collections.abc import Callable
from itertools import count

from tests.support.usb import descriptors as usb
from tests.support.usb import vhci
from tests.support.usb.descriptors import Identity
from tests.support.usb.device import Function
from tests.support.usb.usbip import Setup

SET_CUR, GET_CUR, GET_MIN, GET_MAX, GET_RES, GET_LEN, GET_INFO, GET_DEF = 1, *range(0x81, 0x88)
CAMERA, PROCESSING, OUTPUT = 1, 2, 3
BRIGHTNESS = 2
PAYLOAD_BYTES = 16_384
MOST_PICTURE = 1 << 18
CLOCK_HZ = 48_000_000
SIZES = ((640, 480), (640, 360), (320, 240))
INTERVALS = (333_333, 666_666)
"""Of pictures, in 100 ns: 30 and 15 a second."""


class Camera(Function):
    """Shows what `picture` returns, a JPEG for a size and a number, as fast as was agreed. `brightness` is what was set."""

    speed = vhci.HIGH_SPEED

    def __init__(self, picture: Callable[[int, int, int], bytes], identity: Identity) -> None:
        self.identity = identity
        self.picture = picture
        self.brightness = 0
        self.sent = 0
        self._agreed = agreement(1, INTERVALS[1])
        self._numbers = count()
        self._rest, self._toggle = b"", 0
        self._next_at = 0.0
        self.configuration = usb.configuration(_control(), _streaming(), interfaces=2)

    def control(self, setup: Setup, data: bytes) -> bytes | None:
        entity, selector = setup.index >> 8, setup.value >> 8
        if setup.index & 0xFF == 1:
            return self._negotiated(setup.request, selector, data)
        return self._brightness(setup.request, data) if (entity, selector) == (PROCESSING, BRIGHTNESS) else None

    def due(self) -> float | None:
        return self._next_at

    def come(self, room: int) -> bytes:
        if not self._rest:
            frame, interval = read_agreement(self._agreed)
            self._rest = self.picture(*SIZES[frame - 1], next(self._numbers))
            self._toggle ^= 1
            self._frame_s = interval * 1e-7
        piece, self._rest = self._rest[: PAYLOAD_BYTES - 2], self._rest[PAYLOAD_BYTES - 2 :]
        if not self._rest:
            self.sent += 1
            self._next_at = time.monotonic() + self._frame_s
        return bytes((2, 0x80 | self._toggle | (0 if self._rest else 2))) + piece

    def closed(self) -> None:
        self._rest = b""

    def _negotiated(self, request: int, selector: int, data: bytes) -> bytes | None:
        """Probe (1) and commit (2): what the host wants, bent to what there is."""
        if selector not in {1, 2}:
            return None
        if request == SET_CUR:
            self._agreed = agreement(*read_agreement(data))
            self._rest, self._next_at = b"", 0.0
            return b""
        if request == GET_LEN:
            return struct.pack("<H", len(self._agreed))
        if request == GET_INFO:
            return b"\3"
        return self._agreed

    def _brightness(self, request: int, data: bytes) -> bytes | None:
        if request == SET_CUR:
            if len(data) != 2:
                return None
            (self.brightness,) = struct.unpack("<h", data)
            return b""
        found = {GET_CUR: self.brightness, GET_MIN: -64, GET_MAX: 64, GET_RES: 1, GET_DEF: 0, GET_LEN: 2}
        if request == GET_INFO:
            return b"\3"
        return struct.pack("<h", found[request]) if request in found else None


def agreement(frame: int, interval: int) -> bytes:
    """Return a stream's parameters as UVC 1.1 has them, for the nearest that there is."""
    frame = frame if 1 <= frame <= len(SIZES) else 1
    interval = min(INTERVALS, key=lambda one: abs(one - interval))
    head = struct.pack("<HBBIHHHHHII", 1, 1, frame, interval, 0, 0, 0, 0, 0, MOST_PICTURE, PAYLOAD_BYTES)
    return head + struct.pack("<IBBBB", CLOCK_HZ, 0, 0, 0, 0)


def read_agreement(data: bytes) -> tuple[int, int]:
    """Return frame and interval of a stream's parameters; of those that are cut off, the first there are."""
    if len(data) < 8:
        return 1, INTERVALS[0]
    _, _, frame, interval = struct.unpack_from("<HBBI", data)
    return frame, interval


def _control() -> bytes:
    units = (
        usb.of_class(0x02, struct.pack("<BHBBHHHBH", CAMERA, 0x0201, 0, 0, 0, 0, 0, 2, 0)),
        usb.of_class(0x05, struct.pack("<BBHBHBB", PROCESSING, CAMERA, 0, 2, 1, 0, 0)),
        usb.of_class(0x03, struct.pack("<BHBBB", OUTPUT, 0x0101, 0, PROCESSING, 0)),
    )
    total = 13 + sum(map(len, units))
    head = usb.of_class(0x01, struct.pack("<HHIBB", 0x0110, total, CLOCK_HZ, 1, 1))
    together = usb.of_type(usb.ASSOCIATION, bytes((0, 2, 14, 3, 0, 0)))
    return together + usb.interface(0, (14, 1, 0), extra=head + b"".join(units))


def _streaming() -> bytes:
    frames = b"".join(
        usb.of_class(
            0x07,
            struct.pack(
                "<BBHHIIIIB", number, 0, *size, 1_000_000, 40_000_000, MOST_PICTURE, INTERVALS[1], len(INTERVALS)
            )
            + struct.pack(f"<{len(INTERVALS)}I", *INTERVALS),
        )
        for number, size in enumerate(SIZES, 1)
    )
    form = usb.of_class(0x06, bytes((1, len(SIZES), 0, 1, 0, 0, 0, 0)))
    total = 14 + len(form) + len(frames)
    head = usb.of_class(0x01, struct.pack("<BHBBBBBBBB", 1, total, 0x81, 0, OUTPUT, 0, 0, 0, 1, 0))
    return usb.interface(1, (14, 2, 0), usb.endpoint(0x81, usb.BULK, 512), extra=head + form + frames)
