"""The server in its own thread, with its own event loop."""

import asyncio
import socket
import threading
from collections.abc import Awaitable, Callable

from starlette.types import ASGIApp

from lbr.apps.http import serving

JOIN_S = 0.35


class Serving:
    """Serves an app on listening sockets until `stop`; `beside` runs in the same event loop."""

    def __init__(
        self,
        app: ASGIApp,
        sockets: list[socket.socket],
        *,
        tls: bool,
        plain_here: bool = False,
        beside: Callable[[], Awaitable[None]] | None = None,
    ) -> None:
        self._sockets = sockets
        self._beside = beside
        self._server = serving.Server(app, tls=tls, sockets=True, plain_here=plain_here)
        self._thread = threading.Thread(target=self._run, name="http", daemon=True)

    @property
    def connections(self) -> int:
        """Return the number of open connections."""
        return len(self._server.slots)

    def start(self) -> None:
        """Begin to serve."""
        self._thread.start()

    def stop(self) -> None:
        """End the server within a third of a second; requests under way then end with the process, as do its
        sockets."""
        self._server.leave()
        self._thread.join(JOIN_S)

    def _run(self) -> None:
        try:
            asyncio.run(self._serve())
        finally:
            for one in self._sockets:
                one.close()

    async def _serve(self) -> None:
        beside = asyncio.ensure_future(self._beside()) if self._beside is not None else None
        try:
            await self._server.serve(sockets=self._sockets)
        finally:
            if beside is not None:
                beside.cancel()
                await asyncio.wait([beside], timeout=JOIN_S)
