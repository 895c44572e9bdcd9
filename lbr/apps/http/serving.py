"""uvicorn for the robot's servers: no strangers in the log, every connection in a slot, and late ones cut."""

import asyncio
import logging
import os
import socket
import ssl
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import cast

import uvicorn
from starlette.types import ASGIApp, Receive, Scope, Send

from lbr.apps.http import listening, names
from lbr.apps.http.connection import Connection, connection_of
from lbr.apps.http.slots import LIMIT_S, Slot, Slots
from lbr.errors import InputError

LOOK_S, IDLE_S = 0.2, 1.0
LARGEST_MESSAGE = 16 * 1024
PING_S, PONG_S = 10.0, 10.0
GRACE_S = 1
FAREWELL_S = 0.1
TLS_HANDSHAKE = b"\x16"
"""The first byte of a TLS client (RFC 8446, 5.1); no HTTP method begins with it."""


class Server(uvicorn.Server):
    """A server of an app. Every connection has one of the `slots` from the first packet on.

    - `sockets`: it accepts WebSockets.
    - `tls`: it serves HTTPS, and redirects plain HTTP to it.
    - `plain_here`: it answers plain HTTP from this machine nevertheless.
    """

    def __init__(self, app: ASGIApp, *, tls: bool, sockets: bool = False, plain_here: bool = False) -> None:
        for name in ("uvicorn", "uvicorn.error"):
            logging.getLogger(name).setLevel(logging.CRITICAL)  # strangers could fill the log
        self._app = app
        self._tls = _context() if tls else None
        super().__init__(
            uvicorn.Config(
                _sockets(app),
                http=cast("type[asyncio.Protocol]", lambda **_options: _Door(self.admit)),
                ws="websockets-sansio" if sockets else "none",
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
                backlog=listening.BACKLOG,
                timeout_graceful_shutdown=GRACE_S,
            )
        )
        self.config.load()
        self.slots = Slots()
        self._plain_here = plain_here
        self._wake: Callable[[], object] = lambda: None
        self._greeting: set[asyncio.Task[None]] = set()

    async def main_loop(self) -> None:
        """Serve, and cut overdue connections, until `leave` is called. Without any, only the date is kept up."""
        woken = asyncio.Event()
        self._wake = partial(asyncio.get_running_loop().call_soon_threadsafe, woken.set)
        while not await self.on_tick(0):
            for slot in self.slots.overdue(time.monotonic()):
                slot.cut()
            with suppress(TimeoutError):
                async with asyncio.timeout(LOOK_S if len(self.slots) else IDLE_S):
                    await woken.wait()
            woken.clear()

    def leave(self) -> None:
        """Have it end; may be called from any thread."""
        self.should_exit = True
        with suppress(RuntimeError):  # it has ended
            self._wake()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Close all connections, WebSockets with a reason."""
        for task in self._greeting:
            task.cancel()
        connections = [each for each in self.server_state.connections if isinstance(each, Connection)]
        if farewells := [asyncio.ensure_future(connection.farewell()) for connection in connections]:
            await asyncio.wait(farewells, timeout=FAREWELL_S)
        await super().shutdown(sockets)

    def admit(self, transport: asyncio.Transport) -> None:
        """Admit a new connection, and cut another for it if need be."""
        peer = transport.get_extra_info("peername")
        name = names.peer_name(str(peer[0]) if peer else "")
        slot = Slot(name, transport.abort, transport.is_closing, time.monotonic())
        if (victim := self.slots.enter(slot)) is not None:
            victim.cut()
        self._wake()
        connection = Connection(self._app, self.config, self.server_state, self.slots)
        if self._tls is None:
            transport.set_protocol(connection)
            connection.begin(transport, slot)
        else:
            transport.pause_reading()
            self.slots.to(slot, "greeting", time.monotonic())
            task = asyncio.ensure_future(self._greet(self._tls, transport, connection, slot))
            self._greeting.add(task)
            task.add_done_callback(self._greeting.discard)

    async def _greet(
        self, tls: ssl.SSLContext, transport: asyncio.Transport, connection: Connection, slot: Slot
    ) -> None:
        begins = await _first_byte(transport)
        if begins and begins != TLS_HANDSHAKE:
            transport.set_protocol(connection)
            peer = transport.get_extra_info("peername")
            if not (self._plain_here and peer and names.is_loopback(str(peer[0]))):
                connection.lead_to_https()
            connection.begin(transport, slot)
            transport.resume_reading()
            return
        try:
            secure = await asyncio.get_running_loop().start_tls(
                transport,
                connection,
                tls,
                server_side=True,
                ssl_handshake_timeout=LIMIT_S["greeting"],
                ssl_shutdown_timeout=LIMIT_S["leaving"],
            )
        except (OSError, asyncio.CancelledError):
            secure = None
        if secure is None or secure.is_closing():
            self.slots.leave(slot)
            transport.abort()
        else:
            connection.begin(secure, slot)


class _Door(asyncio.Protocol):
    """A connection before it is admitted; `begun` is set once it sends, or is lost."""

    def __init__(self, admit: Callable[[asyncio.Transport], None]) -> None:
        self.begun = asyncio.Event()
        self._admit = admit

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._admit(cast("asyncio.Transport", transport))

    def connection_lost(self, exc: Exception | None) -> None:
        """End the wait for its first byte."""
        del exc
        self.begun.set()


async def _first_byte(transport: asyncio.Transport) -> bytes:
    """Return the first byte of a connection without reading it; empty if it ends before."""
    loop, door = asyncio.get_running_loop(), cast("_Door", transport.get_protocol())
    with socket.socket(fileno=os.dup(transport.get_extra_info("socket").fileno())) as peeked:
        loop.add_reader(peeked, door.begun.set)
        try:
            await door.begun.wait()
            return peeked.recv(1, socket.MSG_PEEK)
        except OSError:
            return b""
        finally:
            loop.remove_reader(peeked)


def _sockets(app: ASGIApp) -> ASGIApp:
    """Return the app for WebSockets; the server closes them with a reason when it ends."""

    async def serve(scope: Scope, receive: Receive, send: Send) -> None:
        connection = connection_of(scope)
        assert connection is not None
        await app(scope, receive, connection.to_socket(send))

    return serve


def _context() -> ssl.SSLContext:
    """Return the TLS context of this machine's certificate."""
    key, public = listening.certificate()
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    try:
        context.load_cert_chain(public, key)
    except (ssl.SSLError, OSError) as err:
        raise InputError(f"TLS cannot be spoken with {key} and {public}: {err}; mend or remove them") from err
    return context
