"""A connection through this program, which can delay it: it keeps the bytes, and delivers them at once later."""

import selectors
import socket
import threading
from contextlib import suppress
from typing import Literal

Way = Literal["to the robot", "both ways"]
_CHUNK = 65536
_POLL_S = 0.02


class Stalling:
    """Passes TCP connections on to `port` on this machine; `stall` keeps the bytes, `release` delivers them."""

    def __init__(self, port: int) -> None:
        self._target = port
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = int(self._listener.getsockname()[1])
        self._selector = selectors.DefaultSelector()
        self._peer: dict[socket.socket, socket.socket] = {}
        self._outward: set[socket.socket] = set()
        self._kept: list[tuple[socket.socket, bytes]] = []
        self._stalled: Way | None = None
        self._over = False
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def stall(self, way: Way) -> None:
        """Deliver nothing from now on; the connections stay open."""
        self._stalled = way

    def release(self) -> None:
        """Deliver the kept bytes, and go on."""
        self._stalled = None

    def close(self) -> None:
        """End every connection."""
        self._over = True
        self._thread.join()
        for one in (*self._peer, self._listener):
            one.close()
        self._selector.close()

    def _run(self) -> None:
        while not self._over:
            for key, _ in self._selector.select(_POLL_S):
                assert isinstance(key.fileobj, socket.socket)
                self._accept() if key.fileobj is self._listener else self._pass_on(key.fileobj)
            if self._stalled is None:
                kept, self._kept = self._kept, []
                for one, data in kept:
                    _send(one, data)

    def _accept(self) -> None:
        inward, _ = self._listener.accept()
        outward = socket.create_connection(("127.0.0.1", self._target))
        self._peer |= {inward: outward, outward: inward}
        self._outward.add(inward)
        for one in (inward, outward):
            self._selector.register(one, selectors.EVENT_READ)

    def _pass_on(self, one: socket.socket) -> None:
        data = b""
        with suppress(OSError):
            data = one.recv(_CHUNK)
        other = self._peer[one]
        if not data:
            self._selector.unregister(one)
            with suppress(OSError):
                other.shutdown(socket.SHUT_WR)
        elif self._stalled == "both ways" or (self._stalled and one in self._outward):
            self._kept.append((other, data))
        else:
            _send(other, data)


def _send(one: socket.socket, data: bytes) -> None:
    with suppress(OSError):  # it is gone
        one.sendall(data)
