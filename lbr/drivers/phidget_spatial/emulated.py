"""A stand-in for `Phidget22.Devices.Spatial.Spatial` whose unit is at the other end of a socket.

The unit sends records of ten little-endian doubles. They are acceleration (g), turn rate (degrees a second) and field
(gauss) along x, y and z, and its clock (milliseconds). It accepts lines of JSON: `{"interval_ms": 4}`, `{"zero":
true}`. The unit is attached while there is a connection.
"""
# ruff: noqa: N802, N803 - the library's own names

import json
import socket
import struct
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress

from lbr.bus.unix_address import address_of
from lbr.messages.schema import JsonObject

RECORD = struct.Struct("<10d")
_READ_BYTES = 80 * 64

OnData = Callable[[object, Sequence[float], Sequence[float], Sequence[float], float], None]


class EmulatedSpatial:
    """Connects when it is opened; a thread of its own calls the handlers, as in the library."""

    def __init__(self, path: str) -> None:
        self._path = path
        self._on_data: OnData | None = None
        self._on_detach: Callable[[object], None] | None = None
        self._socket: socket.socket | None = None
        self._thread: threading.Thread | None = None

    def setOnSpatialDataHandler(self, handler: OnData | None) -> None:
        """Set the function that is called with every sample."""
        self._on_data = handler

    def setOnDetachHandler(self, handler: Callable[[object], None] | None) -> None:
        """Set the function that is called when the unit is gone."""
        self._on_detach = handler

    def openWaitForAttachment(self, timeout: int) -> None:
        """Connect, or raise OSError."""
        connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        connection.settimeout(timeout / 1000.0)
        try:
            with address_of(self._path) as address:
                connection.connect(address)
        except OSError:
            connection.close()
            raise
        connection.settimeout(None)
        self._socket = connection
        self._thread = threading.Thread(target=self._read, args=(connection,), name="spatial", daemon=True)
        self._thread.start()

    def setDataInterval(self, DataInterval: int) -> None:
        """Set the interval between samples, in milliseconds."""
        self._say({"interval_ms": DataInterval})

    def zeroGyro(self) -> None:
        """Take the gyro's zero."""
        self._say({"zero": True})

    def close(self) -> None:
        """Disconnect, and wait for the thread."""
        connection, self._socket = self._socket, None
        self._on_data = self._on_detach = None
        if connection is not None:
            with suppress(OSError):
                connection.shutdown(socket.SHUT_RDWR)
            connection.close()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join()

    def _say(self, order: JsonObject) -> None:
        if self._socket is None:
            raise ConnectionError("the unit is not attached")
        self._socket.sendall(json.dumps(order).encode() + b"\n")

    def _read(self, connection: socket.socket) -> None:
        buffer = b""
        while True:
            try:
                part = connection.recv(_READ_BYTES)
            except OSError:
                part = b""
            if not part:
                break
            buffer += part
            whole = len(buffer) - len(buffer) % RECORD.size
            for record in RECORD.iter_unpack(buffer[:whole]):
                if self._on_data is not None:
                    self._on_data(self, record[0:3], record[3:6], record[6:9], record[9])
            buffer = buffer[whole:]
        if self._on_detach is not None:
            self._on_detach(self)
