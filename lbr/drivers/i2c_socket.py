"""An i2c bus at the other end of a unix socket: each request is one transaction, answered whole or with an errno."""

import errno
import os
import socket
import time

from lbr.bus.unix_address import address_of
from lbr.capability.tap import Tap
from lbr.drivers.i2c_bus import Bus, encode

DEADLINE_S = 0.05


class SocketBus(Bus):
    """A bus whose every failure is an OSError with an errno that a Pi's bus has too.

    No call takes longer than the deadline. An interrupted call leaves the stream out of step, so the next one
    reconnects.
    """

    def __init__(self, path: str, tap: Tap | None = None, deadline_s: float = DEADLINE_S) -> None:
        self._path = path
        self._deadline_s = deadline_s
        self._socket: socket.socket | None = self._connect()
        super().__init__(tap or Tap())

    def transact(self, address: int, written: bytes, length: int) -> bytes:
        """Send the request, and return the bytes read."""
        return self._transact(encode(address, written, length), length)

    def close(self) -> None:
        """Close the socket; never fails."""
        connection, self._socket = self._socket, None
        if connection is not None:
            connection.close()

    def _connect(self) -> socket.socket:
        connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            connection.settimeout(self._deadline_s)
            with address_of(self._path) as address:
                connection.connect(address)
        except OSError:
            connection.close()
            raise
        return connection

    def _transact(self, request: bytes, expected: int = 0) -> bytes:
        """Return the bytes read, of which `expected` are due."""
        try:
            if self._socket is None:
                self._socket = self._connect()
            answer = self._exchange(self._socket, request, expected)
        except TimeoutError as err:
            self.close()
            raise OSError(errno.ETIMEDOUT, os.strerror(errno.ETIMEDOUT)) from err
        except OSError as err:
            self.close()
            raise OSError(errno.ENODEV, os.strerror(errno.ENODEV)) from err
        if answer[0]:
            raise OSError(answer[0], os.strerror(answer[0]))
        return answer[1:]

    def _exchange(self, connection: socket.socket, request: bytes, expected: int) -> bytes:
        until = time.monotonic() + self._deadline_s
        connection.sendall(request)
        answer = connection.recv(expected + 2)  # one more than is due, so that a peer out of step shows
        while len(answer) != (whole := 1 if answer[:1] > b"\0" else expected + 1):
            left = until - time.monotonic()
            if not left > 0.0:
                raise TimeoutError
            connection.settimeout(left)
            part = connection.recv(whole + 1 - len(answer)) if 0 < len(answer) < whole else b""
            if not part:
                raise ConnectionError("the other end left, or is out of step")
            answer += part
            connection.settimeout(self._deadline_s)
        return answer
