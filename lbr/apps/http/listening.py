"""Sockets that listen, and connections that hold little."""

import ipaddress
import socket
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

from lbr import home
from lbr.bus import certificates
from lbr.errors import InputError

BUFFER_BYTES = 64 * 1024
MOST_CONNECTIONS = 64
IDLE_S = 10.0


class Connection(H11Protocol):
    """A connection that holds little, so that a slow one gets what is newer and not a queue of what was."""

    def connection_made(self, transport: Any) -> None:
        """Bound what waits to be sent, and how long nothing is asked."""
        transport.set_write_buffer_limits(high=BUFFER_BYTES)
        super().connection_made(transport)
        self._last_cycle: object = None
        self._upgraded = False
        self.loop.call_later(IDLE_S, self._check)

    def handle_websocket_upgrade(self, event: Any) -> None:
        """Leave a connection that is a WebSocket from now on to its own timeouts."""
        self._upgraded = True
        super().handle_websocket_upgrade(event)

    def _check(self) -> None:
        """Close a connection that has asked nothing, or only half of something, since the last look."""
        if self._upgraded or self.transport.is_closing():
            return
        idle = self.cycle is None or self.cycle.response_complete
        if idle and self.cycle is self._last_cycle:
            self.transport.abort()
            return
        self._last_cycle = self.cycle if idle else object()
        self.loop.call_later(IDLE_S, self._check)


def listen(host: str, port: int) -> socket.socket:
    """Return a listening socket whose connections hold little; InputError says what is wrong with the address."""
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    except OSError as err:
        raise InputError(f"'{host}' is no address of this machine: {err.strerror or err}") from err
    listening = socket.socket(family, kind, protocol)  # asyncio sends at once only what it knows to be TCP
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER_BYTES)
        if family == socket.AF_INET6:
            listening.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, int(host != "::"))
        listening.bind(address)
        listening.listen(MOST_CONNECTIONS)
    except OSError as err:
        listening.close()
        raise InputError(f"port {port} at {host} cannot be used ({err.strerror})") from err
    return listening


def is_loopback(listening: socket.socket) -> bool:
    """Say whether only this machine reaches a socket."""
    return ipaddress.ip_address(listening.getsockname()[0].partition("%")[0]).is_loopback


def certificate() -> tuple[str, str]:
    """Return the files of the robot's private key and certificate, made on first use."""
    key, public = home.credentials(certificates.self_signed, *certificates.FILES)
    return str(key), str(public)
