"""A camera at `unix:PATH`: a program on this machine, such as the simulation, that sends pictures on a socket."""

import os
import socket
import time
from contextlib import suppress

from lbr.bus.unix_address import address_of
from lbr.capability.context import Device
from lbr.drivers.camera import CameraSettings
from lbr.drivers.camera.picture import Picture
from lbr.drivers.camera.stream_protocol import RecordParser, request
from lbr.errors import DeviceError, MalformedError

CONNECT_S = 1.0
READ_BYTES = 1 << 18
READS = 16
"""The most reads in one call, however fast the sender is."""


class StreamSource:
    """A connection to the sender of the pictures."""

    def __init__(self, device: Device, settings: CameraSettings) -> None:
        self._says = f"device '{device.name}' at {device.address}"
        self._parser = RecordParser()
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM | socket.SOCK_CLOEXEC)
        try:
            self._socket.settimeout(CONNECT_S)
            with address_of(device.address.removeprefix("unix:")) as address:
                self._socket.connect(address)
            self._socket.sendall(request(width=settings.width_px, height=settings.height_px, fps=settings.fps))
            if settings.controls:
                self._socket.sendall(request(controls=settings.controls))
            self._socket.setblocking(False)
        except OSError as err:
            self._socket.close()
            raise DeviceError(f"{self._says} does not answer ({_cause(err)}); start what sends its pictures") from err

    def fileno(self) -> int:
        """Return the socket's descriptor."""
        return self._socket.fileno()

    def take(self) -> list[Picture]:
        """Return the pictures received since the last call."""
        pictures: list[Picture] = []
        for _ in range(READS):
            data = self._read()
            if data is None:
                break
            if not data:
                if pictures:
                    break  # the next call meets the end again
                raise DeviceError(f"{self._says} went away; start what sends its pictures")
            pictures += self._parsed(data)
        return pictures

    def pace(self, fps: float) -> None:
        """Request this rate of pictures; a failed send is ignored, because the connection is then about to end."""
        with suppress(OSError):
            self._socket.sendall(request(fps=fps))

    def close(self) -> None:
        """Close the connection."""
        with suppress(OSError):
            self._socket.close()

    def _read(self) -> bytes | None:
        try:
            return self._socket.recv(READ_BYTES)
        except BlockingIOError:
            return None
        except OSError as err:
            raise DeviceError(f"{self._says} went away ({_cause(err)}); start what sends its pictures") from err

    def _parsed(self, data: bytes) -> list[Picture]:
        now = time.monotonic()
        try:
            return [Picture(jpeg, min(now, taken_ns / 1e9)) for jpeg, taken_ns in self._parser.feed(data)]
        except MalformedError as err:
            raise DeviceError(f"{self._says} sends something else than pictures: {err}") from err


def _cause(err: OSError) -> str:
    return os.strerror(err.errno) if err.errno else str(err)
