"""Where navcam listens, and how it ends: at once, whoever watches."""

import asyncio
import ipaddress
import socket
import ssl
from types import FrameType
from typing import Any

import uvicorn
from starlette.types import ASGIApp
from uvicorn.protocols.http.h11_impl import H11Protocol

from lbr import home
from lbr.apps.navcam.hub import Hub
from lbr.bus import certificates
from lbr.errors import InputError

BUFFER_BYTES = 64 * 1024
MOST_CONNECTIONS = 64
IDLE_S = 10.0
GRACE_S = 1


class Server(uvicorn.Server):
    """Ends the open streams when it is told to end."""

    hub: Hub
    loop: asyncio.AbstractEventLoop

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Take SIGTERM or SIGINT."""
        super().handle_exit(sig, frame)
        self.loop.call_soon_threadsafe(self.hub.close)


class Connection(H11Protocol):
    """A connection that holds little, so that a slow one gets newer pictures and not a queue of old ones."""

    def connection_made(self, transport: Any) -> None:
        """Bound what waits to be sent, and how long nothing is asked."""
        transport.set_write_buffer_limits(high=BUFFER_BYTES)
        super().connection_made(transport)
        self._last_cycle: object = None
        self.loop.call_later(IDLE_S, self._check)

    def _check(self) -> None:
        """Close a connection that has asked nothing, or only half of something, since the last look."""
        if self.transport.is_closing():
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
        family, kind, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    except OSError as err:
        raise InputError(f"--host {host} is no address of this machine: {err}") from err
    listening = socket.socket(family, kind)
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER_BYTES)
        listening.bind(address)
        listening.listen(MOST_CONNECTIONS)
    except OSError as err:
        listening.close()
        raise InputError(f"port {port} at {host} cannot be used ({err.strerror}); choose another by --port") from err
    return listening


def is_loopback(listening: socket.socket) -> bool:
    """Say whether only this machine reaches a socket."""
    return ipaddress.ip_address(listening.getsockname()[0].partition("%")[0]).is_loopback


def certificate() -> tuple[str, str]:
    """Return the files of the robot's private key and certificate, made on first use."""
    key, public = home.credentials(certificates.self_signed, *certificates.FILES)
    return str(key), str(public)


def server(app: ASGIApp, hub: Hub, *, tls: bool) -> Server:
    """Return a server for an app; with `tls` it speaks nothing else."""
    key, public = certificate() if tls else (None, None)
    config = uvicorn.Config(
        app,
        http=Connection,
        ws="none",
        lifespan="off",
        loop="asyncio",
        interface="asgi3",
        access_log=False,
        log_config=None,
        server_header=False,
        proxy_headers=False,
        limit_concurrency=MOST_CONNECTIONS,
        timeout_graceful_shutdown=GRACE_S,
        ssl_keyfile=key,
        ssl_certfile=public,
    )
    config.load()
    if tls and not isinstance(config.ssl, ssl.SSLContext):
        raise InputError("TLS could not be set up, and without it navcam serves this machine only")
    made = Server(config)
    made.hub = hub
    return made
