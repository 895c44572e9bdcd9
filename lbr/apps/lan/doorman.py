"""Holds each new connection before the bus library may read it: hosts with wrong tokens wait.

    accepted, held ──► welcome: released ──► the library reads the token ──► its log: admitted, or refused
                  └──► its host has to wait: released later, or ended

The library accepts connections without asking. So its listening sockets need a mebibyte before a connection counts as
readable (socket(7), SO_RCVLOWAT, which connections inherit). For a released connection a byte is enough; an admitted
message never passes here again. A thread of its own does this within a millisecond of the connection.
"""

import os
import socket
import stat
import threading
from collections import Counter, deque
from collections.abc import Callable, Iterator

from lbr.apps.lan.attempts import Attempts, Refusal, host_of
from lbr.bus.library_log import LibraryLog

HELD_BYTES = 1 << 20
POLL_S = 0.05
"""The longest that a new connection waits to be checked; a check takes a fifth of a millisecond."""
MOST_HELD = 4
"""The most waiting connections of one host; further ones are ended."""
MOST_REFUSALS = 64


class Doorman:
    """Works from `watch` to `close`; `take` returns its reports, `rounds` counts its rounds."""

    def __init__(self, library: LibraryLog, clock: Callable[[], float]) -> None:
        self.rounds = 0
        self._library = library
        self._clock = clock
        self._attempts = Attempts()
        self._refusals: deque[Refusal] = deque(maxlen=MOST_REFUSALS)
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="doorman", daemon=True)

    @property
    def refused(self) -> int:
        """Return the number of wrong tokens in all."""
        return self._attempts.refused

    def watch(self, ports: frozenset[int]) -> None:
        """Hold new connections of this process's listening sockets at these ports, and start admitting them."""
        for listening in _sockets():
            if listening.getsockopt(socket.SOL_SOCKET, socket.SO_ACCEPTCONN) and listening.getsockname()[1] in ports:
                listening.setsockopt(socket.SOL_SOCKET, socket.SO_RCVLOWAT, HELD_BYTES)
        if not self._thread.is_alive():
            self._thread.start()

    def take(self) -> list[Refusal]:
        """Return the reports since the last call."""
        return [self._refusals.popleft() for _ in range(len(self._refusals))]

    def close(self) -> None:
        """Stop admitting connections."""
        self._closing = True
        if self._thread.is_alive():
            self._thread.join(2 * POLL_S)

    def _run(self) -> None:
        while not self._closing:
            for line in self._library.wait(POLL_S):
                refusal = self._attempts.read(line, self._clock())
                if refusal is not None:
                    self._refusals.append(refusal)
            self._look(self._clock())
            self.rounds += 1

    def _look(self, now: float) -> None:
        waiting: Counter[str] = Counter()
        for connection in _sockets():
            if not connection.getsockopt(socket.SOL_SOCKET, socket.SO_RCVLOWAT) > 1:
                continue
            try:
                address = _written(connection.getpeername())
            except OSError:  # it listens, or is closed
                continue
            if self._attempts.knock(address, now):
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVLOWAT, 1)
            else:
                waiting[host_of(address)] += 1
                if waiting[host_of(address)] > MOST_HELD:
                    connection.shutdown(socket.SHUT_RDWR)


def _sockets() -> Iterator[socket.socket]:
    """Yield this process's TCP sockets, of any library; each is valid until the next."""
    for name in os.listdir("/proc/self/fd"):  # noqa: PTH208 - names are all that is wanted
        try:
            if not stat.S_ISSOCK(os.fstat(int(name)).st_mode):
                continue
            tcp = socket.socket(fileno=os.dup(int(name)))
        except OSError:  # closed meanwhile
            continue
        with tcp:
            if tcp.family in {socket.AF_INET, socket.AF_INET6} and tcp.type == socket.SOCK_STREAM:
                yield tcp


def _written(peer: tuple[str, int]) -> str:
    """Return an address in the library's form."""
    host, port = peer[:2]
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
