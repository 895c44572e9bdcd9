"""uvicorn as the robot's servers use it: nothing about strangers in the log, every connection in a slot, late ones
cut."""

import asyncio
import logging
import os
import socket
import ssl
import time
from collections.abc import Callable, Iterable
from typing import Any, cast

import h11
import uvicorn
from starlette.middleware.httpsredirect import HTTPSRedirectMiddleware
from starlette.types import ASGIApp, Scope
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.utils import ClientDisconnected
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from uvicorn.server import ServerState
from websockets.frames import CloseCode
from websockets.protocol import State

from lbr.apps.http import listening, names, peers
from lbr.apps.http.listening import BUFFER_BYTES
from lbr.apps.http.slots import LIMIT_S, Phase, Slot, Slots
from lbr.errors import InputError

LOOK_S = 0.25
LARGEST_HEAD = 16 * 1024
LARGEST_BODY = 512 * 1024
"""Of any request. It exceeds what uvicorn holds (64 KiB) and one reading of asyncio (256 KiB) together: a request is
answered before its body is too large."""
MOST_UNREAD = 16 * 1024 * 1024
"""Of what still comes after an answer: it is thrown away, so that its sender reads the answer and not a reset."""
MOST_PIECES = 256
"""Of a body, so that no client keeps the thread busy with pieces of a byte each: 43,000 of them fit into one reading
and took 0.2 s."""
LARGEST_MESSAGE = 16 * 1024
MOST_TOLD_BYTES = 32 * 1024
"""What a viewer may send in a second, pings and all; a browser sends six bytes in ten."""
PING_S, PONG_S = 10.0, 10.0
GRACE_S = 1
TLS_HANDSHAKE = b"\x16"
"""A client's first byte where it speaks TLS (RFC 8446, 5.1); no method of HTTP begins so."""


class _Bounded(h11.Connection):
    """The server's end of a connection, for which a body that is too large or in too many pieces is no valid
    request."""

    def __init__(self) -> None:
        super().__init__(h11.SERVER, LARGEST_HEAD)
        self._pieces = self._bytes = 0

    def next_event(self) -> h11.Event | type[h11.NEED_DATA] | type[h11.PAUSED]:
        """Return what comes next of what was received."""
        event = super().next_event()
        if isinstance(event, h11.Request):
            self._pieces = self._bytes = 0
            event = _origin_form(event)
        elif isinstance(event, h11.Data):
            self._pieces += 1
            self._bytes += len(event.data)
            if self._pieces > MOST_PIECES or self._bytes > LARGEST_BODY:
                raise h11.RemoteProtocolError("this body is too large, or in too many pieces")
        return event


def _origin_form(request: h11.Request) -> h11.Request:
    """Return a request as it is said without a proxy: one that names its host in its address as well (RFC 9112, 3.2.2).
    One that names two hosts stays as it is, and is for no path that there is."""
    scheme, sign, rest = request.target.partition(b"://")
    if not sign or scheme.lower() not in {b"http", b"https"}:
        return request
    at = min((where for where in map(rest.find, (b"/", b"?")) if where >= 0), default=len(rest))
    host, path = rest[:at], rest[at:]
    if [value.lower() for name, value in request.headers if name == b"host"] != [host.lower()]:
        return request
    target = path if path.startswith(b"/") else b"/" + path
    headers = list(request.headers)
    return h11.Request(method=request.method, headers=headers, target=target, http_version=request.http_version)


class Viewing(WebSocketsSansIOProtocol):
    """A WebSocket that is cut when much more comes by it than a viewer has to say: pings, too, are work."""

    _since = _bytes = 0.0

    def data_received(self, data: bytes) -> None:
        """Take what was sent."""
        now = time.monotonic()
        if now - self._since > 1.0:
            self._since, self._bytes = now, 0.0
        self._bytes += len(data)
        if self._bytes > MOST_TOLD_BYTES:
            self.transport.abort()
        else:
            super().data_received(data)

    def shutdown(self) -> None:
        """Close it with the reason: the server ends."""
        if self.handshake_complete and not self.close_sent:
            self.queue.put_nowait({"type": "websocket.disconnect", "code": CloseCode.GOING_AWAY})
            if self.conn.state is State.OPEN:  # else the viewer has begun to close
                self.conn.send_close(CloseCode.GOING_AWAY, "the server ends")
                self.transport.write(b"".join(self.conn.data_to_send()))
            self.close_sent = True
        super().shutdown()

    def keepalive_timeout(self) -> None:
        """Cut a viewer that answers no ping: a device that sleeps reads no farewell."""
        self.transport.abort()

    async def send(self, message: Any) -> None:
        """Send to the viewer; ClientDisconnected once the connection was closed for what the viewer did."""
        if self.close_sent:
            raise ClientDisconnected
        await super().send(message)


class _Lingering:
    """A transport that, where more comes than was read, ends our side first and listens on until the other side ends,
    too: who is closed with something unread is told nothing but that, not even the answer before it."""

    def __init__(self, transport: asyncio.Transport, linger: Callable[[], bool]) -> None:
        self.transport = transport
        self._linger = linger
        self.lingers = False

    def __getattr__(self, name: str) -> Any:
        return getattr(self.transport, name)

    def is_closing(self) -> bool:
        """Say whether nothing more is written."""
        return self.lingers or self.transport.is_closing()

    def close(self) -> None:
        """Write what is to be written, and end."""
        if self.is_closing() or not self.transport.can_write_eof() or not self._linger():
            self.transport.close()
            return
        self.lingers = True
        self.transport.write_eof()
        self.transport.resume_reading()


class Connection(H11Protocol):
    """A connection that holds little, so that a slow one gets what is newer, and that says in its slot what it does."""

    transport: asyncio.Transport
    _lingering: _Lingering

    def __init__(
        self, config: uvicorn.Config, state: ServerState, slots: Slots, loop: asyncio.AbstractEventLoop
    ) -> None:
        super().__init__(config, state, {"connection": self}, loop)
        self.conn = _Bounded()
        self.owner: bool | None = None
        """Whether this robot's own user is at the other end, once the server has looked."""
        self.whose: str | None = None
        """Whose program is at the other end, once the server has looked: see `peers.whose`."""
        self._slots = slots
        self._slot: Slot | None = None
        self._early = b""
        self._marked: object = None
        self._unread = 0

    def begin(self, transport: asyncio.Transport, slot: Slot) -> None:
        """Serve on a connection that stands."""
        self._slot = slot
        transport.set_write_buffer_limits(high=BUFFER_BYTES)
        self._lingering = _Lingering(transport, self._has_more_to_come)
        self.connection_made(cast("asyncio.Transport", self._lingering))
        self._to("idle")
        if self._early:
            early, self._early = self._early, b""
            self.data_received(early)

    def mark(self, phase: Phase) -> None:
        """Have the request that is under way count as something else than asking."""
        if self._marked is not self:
            self._marked = self.cycle
        self._to(phase)

    def lead_to_https(self) -> None:
        """Answer each request with its address by https."""
        self.app = HTTPSRedirectMiddleware(self.app)
        self.ws_protocol_class = None

    @property
    def is_held(self) -> bool:
        """Return whether the other end has not cut the connection, as far as the kernel knows: see `peers.is_held`."""
        return peers.is_held(self.transport.get_extra_info("socket"))

    def data_received(self, data: bytes) -> None:
        """Take what was sent; what comes before the other side of TLS has begun waits for that."""
        if self._slot is None:
            self._early += data
            return
        if self._lingering.lingers:
            self._unread += len(data)
            if self._unread > MOST_UNREAD:
                self.transport.abort()
            return
        try:
            super().data_received(data)
        except h11.LocalProtocolError:  # what is wrong came after the answer, which its sender still has to read
            self.transport.close()
        self._look()

    def send_400_response(self, msg: str) -> None:
        """Say that what was sent is no request; one that is under way is done, if it can be, and not answered."""
        if self.cycle is not None:
            self.cycle.disconnected = True
            self.cycle.message_event.set()
        super().send_400_response(msg)

    def on_response_complete(self) -> None:
        """Wait for the next request."""
        super().on_response_complete()
        self._look()

    def connection_lost(self, exc: Exception | None) -> None:
        """Count one less."""
        if self._slot is not None:
            self._slots.leave(self._slot)
            super().connection_lost(exc)

    def handle_websocket_upgrade(self, event: Any) -> None:
        """Leave the connection to the WebSocket; it asks until who answers it calls it `watching`.

        A WebSocket ends by a message, so that its transport does not listen on once it is closed.
        """
        self._marked = self
        self.transport = self._lingering.transport
        self._to("asking")
        super().handle_websocket_upgrade(event)

    def _look(self) -> None:
        """Say what the connection does: of a body that is not whole when its request is answered, the rest is waited
        for as a head is."""
        if self._marked is self:
            return
        if self.transport.is_closing():
            self._to("leaving")
            return
        if self.cycle is not None and not self.cycle.response_complete:
            if _ends_doubtfully(self.cycle.scope["headers"]):
                self.cycle.keep_alive = False
            if self._marked is not self.cycle:
                self._to("asking")
        else:
            unfinished = self.conn.trailing_data[0] or self.conn.their_state is h11.SEND_BODY
            self._to("head" if unfinished else "idle")

    def _has_more_to_come(self) -> bool:
        """Say whether more of a request is on its way than was read, as far as what was read tells."""
        return self.conn.their_state in {h11.SEND_BODY, h11.ERROR} or bool(self.conn.trailing_data[0])

    def _to(self, phase: Phase) -> None:
        if self._slot is not None:
            self._slots.to(self._slot, phase, time.monotonic())


class Server(uvicorn.Server):
    """Serves with every connection in one of `slots`, from the first packet on.

    With a certificate it serves TLS. What comes without is led to https; with `plain_here` this machine's own is
    served.
    """

    def __init__(self, config: uvicorn.Config, *, plain_here: bool = False) -> None:
        super().__init__(config)
        self.slots = Slots()
        self._plain_here = plain_here
        self._looking: asyncio.TimerHandle | None = None
        self._greeting: set[asyncio.Task[None]] = set()

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Listen."""
        loop = asyncio.get_running_loop()
        self.servers = [
            await loop.create_server(lambda: _Door(self.admit), sock=sock, backlog=listening.BACKLOG)
            for sock in sockets or ()
        ]
        self._look()
        self.started = True

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End what is open, in order where it can be."""
        if self._looking is not None:
            self._looking.cancel()
        for task in self._greeting:
            task.cancel()
        await super().shutdown(sockets)

    def admit(self, transport: asyncio.Transport) -> None:
        """Take a new connection in, and cut another for it if need be."""
        peer = transport.get_extra_info("peername")
        slot = Slot(names.who(str(peer[0]) if peer else ""), transport.abort, transport.is_closing, time.monotonic())
        victim = self.slots.enter(slot)
        if victim is not None:
            victim.cut()
        connection = Connection(self.config, self.server_state, self.slots, asyncio.get_running_loop())
        if self.config.ssl is None:
            transport.set_protocol(connection)
            connection.begin(transport, slot)
        else:
            transport.pause_reading()
            self.slots.to(slot, "greeting", time.monotonic())
            task = asyncio.ensure_future(self._greet(transport, connection, slot))
            self._greeting.add(task)
            task.add_done_callback(self._greeting.discard)

    async def _greet(self, transport: asyncio.Transport, connection: Connection, slot: Slot) -> None:
        assert self.config.ssl is not None
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
                self.config.ssl,
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

    def _look(self) -> None:
        now = time.monotonic()
        for slot in self.slots.overdue(now):
            slot.cut()
        self._looking = asyncio.get_running_loop().call_later(LOOK_S, self._look)


class _Door(asyncio.Protocol):
    """What a connection is before it is let in; `begun` is set once it sends, or is over."""

    def __init__(self, admit: Callable[[asyncio.Transport], None]) -> None:
        self.begun = asyncio.Event()
        self._admit = admit

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._admit(cast("asyncio.Transport", transport))

    def connection_lost(self, exc: Exception | None) -> None:
        """Let nobody wait for it."""
        del exc
        self.begun.set()


async def _first_byte(transport: asyncio.Transport) -> bytes:
    """Return what a connection begins with, unread; empty if it ends before."""
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


def _ends_doubtfully(headers: Iterable[tuple[bytes, bytes]]) -> bool:
    """Say whether a request tells its length in two ways (RFC 9112, 6.1): what follows it may be another's for a
    proxy."""
    said = {name for name, _value in headers}
    return b"content-length" in said and b"transfer-encoding" in said


def connection_of(scope: Scope) -> Connection | None:
    """Return the connection that a request came by; None outside of a `Server`."""
    found = scope.get("state", {}).get("connection")
    return found if isinstance(found, Connection) else None


def left_behind(scope: Scope) -> bytes | None:
    """Return the rest of a body that came whole before its sender left; None if some of it is missing."""
    connection = connection_of(scope)
    cycle = connection.cycle if connection is not None else None
    return None if cycle is None or cycle.scope["state"] is not scope["state"] or cycle.more_body else bytes(cycle.body)


def config(app: ASGIApp, *, tls: bool, sockets: bool = False) -> uvicorn.Config:
    """Return what uvicorn is to know; with `tls` it speaks nothing else, and `sockets` are WebSockets."""
    for name in ("uvicorn", "uvicorn.error"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # strangers would fill the log
    key, public = listening.certificate() if tls else (None, None)
    made = uvicorn.Config(
        app,
        http="h11",
        ws=Viewing if sockets else "none",
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
        h11_max_incomplete_event_size=LARGEST_HEAD,
        timeout_graceful_shutdown=GRACE_S,
        ssl_keyfile=key,
        ssl_certfile=public,
    )
    try:
        made.load()
    except (ssl.SSLError, OSError) as err:
        raise InputError(f"TLS cannot be spoken with {key} and {public}: {err}; mend or remove them") from err
    if tls and not isinstance(made.ssl, ssl.SSLContext):
        raise InputError("TLS could not be set up: see credentials/bus.key and bus.crt in the robot's home")
    return made
