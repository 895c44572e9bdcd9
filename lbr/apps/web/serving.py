"""uvicorn in a thread of its own, with an event loop of its own."""

import asyncio
import logging
import socket
import ssl
import threading
from collections.abc import Awaitable, Callable
from typing import Any, ClassVar

import uvicorn
from starlette.types import ASGIApp

from lbr.apps.http import listening
from lbr.apps.http.listening import MOST_CONNECTIONS
from lbr.apps.web.streams import MOST_VIEWERS
from lbr.errors import DeviceError

MOST_OF_ONE = 40
"""Connections from one address; what is more is cut."""
MOST_PLAIN = MOST_CONNECTIONS - MOST_VIEWERS - 1
"""All together, so that there is always room for one more: somebody may want to stop the robot."""
LARGEST_HEAD = 16 * 1024
LARGEST_MESSAGE = 4096
PING_S, PONG_S = 10.0, 10.0
GRACE_S = 1
JOIN_S = 0.35


class Connection(listening.Connection):
    """A connection of which one address may have only so many, and fewer while others want some."""

    open_from: ClassVar[dict[str, dict["Connection", None]]] = {}

    def connection_made(self, transport: Any) -> None:
        """Cut what is too many from one address; where all have too many, the oldest of who has most."""
        peer = transport.get_extra_info("peername")
        self._from = str(peer[0]) if peer else ""
        own = self.open_from.setdefault(self._from, {})
        own[self] = None
        super().connection_made(transport)
        if len(own) > MOST_OF_ONE:
            transport.abort()
        elif sum(map(len, self.open_from.values())) > MOST_PLAIN:
            most = max(self.open_from, key=lambda address: len(self.open_from[address]))
            oldest = next(iter(self.open_from[most]))
            oldest.leave()
            oldest.transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        """Count one less; WebSockets are counted by themselves from their beginning."""
        self.leave()
        super().connection_lost(exc)

    def handle_websocket_upgrade(self, event: Any) -> None:
        """Leave the count to the WebSocket."""
        self.leave()
        super().handle_websocket_upgrade(event)

    def leave(self) -> None:
        """Count for nobody any more."""
        own = self.open_from.get(self._from, {})
        own.pop(self, None)
        if not own:
            self.open_from.pop(self._from, None)


class Serving:
    """Serves an app on a listening socket until `stop`; `beside` runs in the same event loop."""

    def __init__(
        self, app: ASGIApp, sock: socket.socket, *, tls: bool, beside: Callable[[], Awaitable[None]] | None = None
    ) -> None:
        self._socket = sock
        self._beside = beside
        self._server = uvicorn.Server(_config(app, tls=tls))
        self._thread = threading.Thread(target=self._run, name="http", daemon=True)
        Connection.open_from.clear()

    @property
    def connections(self) -> int:
        """How many connections are open."""
        return len(self._server.server_state.connections)

    def start(self) -> None:
        """Begin to serve."""
        self._thread.start()

    def stop(self) -> None:
        """End it, at most a third of a second later; what is under way then ends with the process."""
        self._server.should_exit = True
        if self._thread.is_alive():
            self._thread.join(JOIN_S)
        self._socket.close()

    def _run(self) -> None:
        asyncio.run(self._serve())

    async def _serve(self) -> None:
        beside = asyncio.ensure_future(self._beside()) if self._beside is not None else None
        try:
            await self._server.serve(sockets=[self._socket])
        finally:
            if beside is not None:
                beside.cancel()
                await asyncio.wait([beside], timeout=JOIN_S)


def _config(app: ASGIApp, *, tls: bool) -> uvicorn.Config:
    for name in ("uvicorn", "uvicorn.error"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # strangers would fill the log
    key, public = listening.certificate() if tls else (None, None)
    config = uvicorn.Config(
        app,
        http=Connection,
        ws="websockets-sansio",
        ws_max_size=LARGEST_MESSAGE,
        ws_ping_interval=PING_S,
        ws_ping_timeout=PONG_S,
        ws_per_message_deflate=False,
        lifespan="off",
        loop="asyncio",
        interface="asgi3",
        access_log=False,
        log_config=None,
        server_header=False,
        proxy_headers=False,
        limit_concurrency=MOST_CONNECTIONS,
        h11_max_incomplete_event_size=LARGEST_HEAD,
        timeout_graceful_shutdown=GRACE_S,
        ssl_keyfile=key,
        ssl_certfile=public,
    )
    config.load()
    if tls and not isinstance(config.ssl, ssl.SSLContext):
        raise DeviceError("TLS could not be set up: see credentials/bus.key and bus.crt in the robot's home")
    return config
