"""A unix socket in place of a device without a tty: an i2c bus, a camera."""

import select
import socket
from contextlib import suppress
from pathlib import Path
from typing import Self

from lbr.bus.unix_address import address_of
from lbr.errors import DeviceError

_READ_BYTES = 65_536
_MOST_CLIENTS = 8
_PREFIX = "unix:"


class SocketPort:
    """Listens at `path` and serves its clients; never blocks. A number identifies each client."""

    def __init__(self, address: str | Path) -> None:
        self.path = Path(str(address).removeprefix(_PREFIX))
        self._poll: select.epoll | None = None
        self._listener: socket.socket | None = None
        self._clients: dict[int, socket.socket] = {}
        self._identity: tuple[int, int] | None = None

    def __enter__(self) -> Self:
        self.plug()
        return self

    def __exit__(self, *_: object) -> None:
        self.unplug()

    @property
    def plugged(self) -> bool:
        """Return whether clients can connect."""
        return self._poll is not None

    @property
    def clients(self) -> tuple[int, ...]:
        """Return the connected clients."""
        return tuple(self._clients)

    def fileno(self) -> int:
        """Return a descriptor that is readable when a client wants something; raise DeviceError while unplugged."""
        if self._poll is None:
            raise DeviceError(f"emulated port {self.path}: it is unplugged")
        return self._poll.fileno()

    def plug(self) -> None:
        """Listen; raise DeviceError if the path is taken by something that is not a socket, or is invalid."""
        if self._poll is not None:
            return
        if self.path.exists() and not (self.path.is_socket() or self.path.is_symlink()):
            raise DeviceError(f"emulated port {self.path}: something else is there; remove it or change the address")
        listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            unfinished = self.path.with_name(f".{self.path.name}")
            unfinished.unlink(missing_ok=True)
            listener.setblocking(False)
            with address_of(unfinished) as address:
                listener.bind(address)
            listener.listen(_MOST_CLIENTS)
            unfinished.replace(self.path)  # from here on, clients can connect
            stat = self.path.stat()
        except OSError as err:
            listener.close()
            reason = err.strerror or err
            raise DeviceError(f"emulated port {self.path}: {reason}; is its folder writable?") from err
        self._identity = (stat.st_dev, stat.st_ino)
        self._listener, self._poll = listener, select.epoll()
        self._poll.register(listener.fileno(), select.EPOLLIN)

    def unplug(self) -> None:
        """Close every connection and remove the name."""
        for client in self.clients:
            self.drop(client)
        if self._listener is not None:
            self._listener.close()
            self._unlink()
        if self._poll is not None:
            self._poll.close()
        self._listener = self._poll = None

    def receive(self) -> list[tuple[int, bytes]]:
        """Return the bytes of clients since the last call; empty bytes: the client is new, or gone from `clients`."""
        if self._poll is None or self._listener is None:
            return []
        news = []
        for descriptor, _ in self._poll.poll(0):
            if descriptor == self._listener.fileno():
                news += self._accept()
            elif descriptor in self._clients:
                news.append((descriptor, self._read(descriptor)))
        return news

    def send(self, client: int, data: bytes) -> int:
        """Send as much as possible now and return the number of bytes; a client that is gone is dropped."""
        connection = self._clients.get(client)
        if connection is None:
            return 0
        try:
            return connection.send(data)
        except BlockingIOError:
            return 0
        except OSError:
            self.drop(client)
            return 0

    def drop(self, client: int) -> None:
        """End a connection."""
        connection = self.hand_over(client)
        if connection is not None:
            connection.close()

    def hand_over(self, client: int) -> socket.socket | None:
        """Return a connection for another owner, and forget it."""
        connection = self._clients.pop(client, None)
        if connection is not None and self._poll is not None:
            with suppress(OSError):
                self._poll.unregister(client)
        return connection

    def _accept(self) -> list[tuple[int, bytes]]:
        if self._listener is None or self._poll is None:
            return []
        try:
            connection, _ = self._listener.accept()
        except OSError:
            return []
        if len(self._clients) >= _MOST_CLIENTS:
            connection.close()
            return []
        connection.setblocking(False)
        self._clients[connection.fileno()] = connection
        self._poll.register(connection.fileno(), select.EPOLLIN)
        return [(connection.fileno(), b"")]

    def _read(self, client: int) -> bytes:
        try:
            data = self._clients[client].recv(_READ_BYTES)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self.drop(client)
        return data

    def _unlink(self) -> None:
        with suppress(OSError):
            stat = self.path.stat()
            if (stat.st_dev, stat.st_ino) == self._identity:
                self.path.unlink()
