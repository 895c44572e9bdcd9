"""A connection of a server: HTTP/1.1 by h11 for an ASGI app, with small buffers and its phase in a slot."""

import asyncio
import time
from collections.abc import Iterable
from contextlib import suppress
from http import HTTPStatus
from typing import Any
from urllib.parse import unquote

import h11
import uvicorn
from starlette.middleware.httpsredirect import HTTPSRedirectMiddleware
from starlette.types import ASGIApp, Message, Scope, Send
from uvicorn.server import ServerState

from lbr.apps.http import peers
from lbr.apps.http.listening import BUFFER_BYTES
from lbr.apps.http.slots import Phase, Slot, Slots

LARGEST_HEAD = 16 * 1024
LARGEST_BODY = 512 * 1024
"""The most bytes of a body.

The unread buffer (64 KiB) plus one read (256 KiB) is less, so that the app can answer before.
"""
MOST_HELD = 64 * 1024
MOST_UNREAD = 16 * 1024 * 1024
"""The most bytes to discard after an answer, so that the sender reads the answer and not a reset."""
MOST_PIECES = 256
"""The most pieces of a body. Pieces of one byte would block the thread: 43,000 fit into one read and took 0.2 s."""
MOST_VIEWER_BYTES = 32 * 1024
"""The most bytes that a viewer may send in a second, pings included; a browser sends six bytes in ten seconds."""
GOING_AWAY = 1001
BAD_REQUEST = b"Invalid HTTP request received."
CLOSE = (b"connection", b"close")


class Exchange:
    """A request and its answer, as the app receives and sends them."""

    def __init__(self, connection: "Connection", scope: Scope, *, is_invited: bool) -> None:
        self.phase: Phase = "asking"
        self.is_whole = self.is_gone = self.is_done = False
        """Each is True once its event has happened: the body complete, the sender gone, the answer complete."""
        self._connection = connection
        self._scope = scope
        self._is_invited = is_invited
        self._body = bytearray()
        self._pieces = self._bytes = 0
        self._is_passed_on = False
        self._changed = asyncio.Event()

    async def run(self, app: ASGIApp) -> None:
        """Run the app; close the connection after an incomplete answer, so that its reader notices."""
        try:
            await app(self._scope, self._receive, self._send)
        finally:
            if not self.is_done:
                self._connection.close()

    def add(self, part: bytes) -> None:
        """Add a part of the body; raise RemoteProtocolError if the body is too large or in too many pieces."""
        self._pieces += 1
        self._bytes += len(part)
        if self._pieces > MOST_PIECES or self._bytes > LARGEST_BODY:
            raise h11.RemoteProtocolError("this body is too large, or in too many pieces")
        if not self.is_done:
            self._body += part
            self._changed.set()
            if len(self._body) > MOST_HELD:
                self._connection.transport.pause_reading()

    def end(self) -> None:
        """Mark the body as complete."""
        self.is_whole = True
        self._changed.set()

    def leave(self) -> None:
        """Mark the sender as gone, unless the answer is complete."""
        self.is_gone = not self.is_done
        self._changed.set()

    async def _receive(self) -> Message:
        """Return the next part of the body; a complete body can still be read after its sender has left."""
        if self._is_invited and not self.is_gone:
            self._is_invited = False
            self._connection.write(h11.InformationalResponse(status_code=100, headers=[], reason=b"Continue"))
        while not (self._has_more or self.is_gone or self.is_done):
            self._connection.transport.resume_reading()
            self._changed.clear()
            await self._changed.wait()
        if not self._has_more or self.is_done:
            return {"type": "http.disconnect"}
        part, self._body = bytes(self._body), bytearray()
        self._is_passed_on = self.is_whole
        return {"type": "http.request", "body": part, "more_body": not self.is_whole}

    @property
    def _has_more(self) -> bool:
        return bool(self._body) or (self.is_whole and not self._is_passed_on)

    async def _send(self, message: Message) -> None:
        """Send a part of the answer once the connection is writable; discard it if the sender has left."""
        await self._connection.is_writable.wait()
        if self.is_gone:
            return
        if message["type"] == "http.response.start":
            self._is_invited = False
            status, headers = HTTPStatus(message["status"]), [*self._connection.headers, *message.get("headers", ())]
            if _ends_doubtfully(self._scope["headers"]):
                headers.append(CLOSE)
            self._connection.write(h11.Response(status_code=status, headers=headers, reason=status.phrase.encode()))
            return
        self._connection.write(h11.Data(data=b"" if self._scope["method"] == "HEAD" else message.get("body", b"")))
        if not message.get("more_body", False):
            self._connection.write(h11.EndOfMessage())
            self.is_done = True
            self._changed.set()
            self._connection.answered()


class Connection(asyncio.Protocol):
    """A connection in its slot: a sequence of exchanges, or a WebSocket."""

    transport: asyncio.Transport

    def __init__(self, app: ASGIApp, config: uvicorn.Config, state: ServerState, slots: Slots) -> None:
        self.whose: str | None = None
        """The user of the peer's program, see `peers.whose`; None until the server has checked."""
        self.is_writable = asyncio.Event()
        self.is_writable.set()
        self._app = app
        self._config = config
        self._takes_sockets = config.ws_protocol_class is not None
        self._state = state
        self._open: set[Any] = state.connections
        self._slots = slots
        self._slot: Slot | None = None
        self._early = b""
        self._http = h11.Connection(h11.SERVER, LARGEST_HEAD)
        self._exchange: Exchange | None = None
        self._socket: Any = None
        self._send: Send | None = None
        self._viewer_since = self._viewer_bytes = 0.0
        self._ends = self._lingers = False
        self._unread = 0

    def begin(self, transport: asyncio.Transport, slot: Slot) -> None:
        """Start to serve on an open transport."""
        self.transport, self._slot = transport, slot
        transport.set_write_buffer_limits(high=BUFFER_BYTES)
        self._open.add(self)
        self._look()
        if self._early:
            early, self._early = self._early, b""
            self.data_received(early)

    def lead_to_https(self) -> None:
        """Redirect each request to https."""
        self._app, self._takes_sockets = HTTPSRedirectMiddleware(self._app), False

    def mark(self, phase: Phase) -> None:
        """Set the phase of the current request, such as `stopping`."""
        if self._exchange is not None:
            self._exchange.phase = phase
        self._to(phase)

    @property
    def headers(self) -> list[tuple[bytes, bytes]]:
        """Return the headers of every answer."""
        return self._state.default_headers

    @property
    def is_held(self) -> bool:
        """Return whether the connection still stands, see `peers.is_held`."""
        return peers.is_held(self.transport.get_extra_info("socket"))

    @property
    def is_closing(self) -> bool:
        """Return whether the connection accepts no more writes."""
        return self._lingers or self.transport.is_closing()

    @property
    def has_left(self) -> bool:
        """Return whether the sender of the current request has left."""
        return self._exchange is not None and self._exchange.is_gone

    def data_received(self, data: bytes) -> None:
        """Accept bytes; those that arrive before the TLS handshake is complete wait for it."""
        if self._slot is None:
            self._early += data
        elif self._lingers:
            self._unread += len(data)
            if self._unread > MOST_UNREAD:
                self.transport.abort()
        elif self._socket is not None:
            self._view(data)
        else:
            self._http.receive_data(data)
            self._go_on()

    def connection_lost(self, exc: Exception | None) -> None:
        """Release the slot, and end the exchange or the WebSocket."""
        self._open.discard(self)
        self.is_writable.set()
        if self._exchange is not None:
            self._exchange.leave()
        if self._socket is not None:
            self._socket.connection_lost(exc)
        if self._slot is not None:
            self._slots.leave(self._slot)

    def pause_writing(self) -> None:
        """Suspend answers."""
        self.is_writable.clear()
        if self._socket is not None:
            self._socket.pause_writing()

    def resume_writing(self) -> None:
        """Resume answers."""
        self.is_writable.set()
        if self._socket is not None:
            self._socket.resume_writing()

    def shutdown(self) -> None:
        """Close after the current answer; uvicorn calls it when the server ends."""
        self._ends = True
        if not self._is_asked and self._socket is None:
            self.close()

    def close(self) -> None:
        """Close the connection; with unread bytes, only our side, and the rest once the peer has closed too.

        A full close with unread bytes resets the connection, and the peer may lose the answer before it.
        """
        if self.is_closing:
            return
        if self._exchange is not None:
            self._exchange.leave()
        more = self._http.their_state in {h11.SEND_BODY, h11.ERROR} or self._http.trailing_data[0]
        if self._socket is None and more and self.transport.can_write_eof():
            self._lingers = True
            self.transport.write_eof()
            self.transport.resume_reading()
        else:
            self.transport.close()
        self._look()

    def write(self, event: h11.Event) -> None:
        """Write a part of an answer."""
        data = self._http.send(event)
        if data:
            self.transport.write(data)

    def answered(self) -> None:
        """Continue with the next request, or close."""
        if self._ends or self._http.our_state is h11.MUST_CLOSE:
            self.close()
        else:
            self.transport.resume_reading()
            self._go_on()

    async def farewell(self) -> None:
        """Close a WebSocket with the reason that the server ends."""
        send, self._send = self._send, None
        if send is not None and not self.is_closing:
            await send({"type": "websocket.close", "code": GOING_AWAY, "reason": "the server ends"})

    def to_socket(self, send: Send) -> Send:
        """Return the app's send function for a WebSocket; it raises OSError once the connection is closed."""
        self._send = send

        async def send_open(message: Message) -> None:
            if self._send is None or self.is_closing:
                raise OSError("the viewer has gone")
            await send(message)

        return send_open

    @property
    def _is_asked(self) -> bool:
        return self._exchange is not None and not self._exchange.is_done

    def _view(self, data: bytes) -> None:
        """Pass a viewer's bytes to the WebSocket; abort the connection above the limit, which pings count for."""
        now = time.monotonic()
        if now - self._viewer_since > 1.0:
            self._viewer_since, self._viewer_bytes = now, 0.0
        self._viewer_bytes += len(data)
        if self._viewer_bytes > MOST_VIEWER_BYTES:
            self.transport.abort()
        else:
            self._socket.data_received(data)

    def _go_on(self) -> None:
        """Handle the received events; the next request waits for the answer to the current one."""
        try:
            while self._take(self._http.next_event()):
                pass
        except h11.RemoteProtocolError:
            self._refuse()
        if self._socket is None:
            self._look()

    def _take(self, event: h11.Event | type[h11.NEED_DATA] | type[h11.PAUSED]) -> bool:
        """Handle an event; return whether another may follow at once."""
        if isinstance(event, h11.Data) and self._exchange is not None:
            self._exchange.add(event.data)
            return True
        if isinstance(event, h11.EndOfMessage) and self._exchange is not None:
            self._exchange.end()
            return True
        if isinstance(event, h11.Request):
            return self._ask(_origin_form(event))
        if event is h11.PAUSED and self._http.our_state is h11.DONE and self._http.their_state is h11.DONE:
            self._http.start_next_cycle()
            self._exchange = None
            return True
        if event is h11.PAUSED:
            self.transport.pause_reading()
        return False

    def _ask(self, request: h11.Request) -> bool:
        path, _, query = request.target.partition(b"?")
        headers = [(bytes(name), bytes(value)) for name, value in request.headers]
        if self._takes_sockets and _asks_for_socket(headers):
            self._become_socket(request, headers)
            return False
        scope: Scope = {
            "type": "http",
            "asgi": {"version": "3.0", "spec_version": "2.3"},
            "http_version": request.http_version.decode("ascii"),
            "method": request.method.decode("ascii"),
            "scheme": "https" if self.transport.get_extra_info("sslcontext") else "http",
            "path": unquote(path.decode("ascii")),
            "raw_path": path,
            "root_path": "",
            "query_string": query,
            "headers": headers,
            "client": _end(self.transport.get_extra_info("peername")),
            "server": _end(self.transport.get_extra_info("sockname")),
            "state": {"connection": self},
        }
        self._exchange = Exchange(self, scope, is_invited=self._http.they_are_waiting_for_100_continue)
        task = asyncio.get_running_loop().create_task(self._exchange.run(self._app))
        self._state.tasks.add(task)
        task.add_done_callback(self._ran)
        return True

    def _ran(self, task: asyncio.Task[None]) -> None:
        """Discard a finished task; the app has already reported its exception."""
        self._state.tasks.discard(task)
        if not task.cancelled():
            task.exception()

    def _become_socket(self, request: h11.Request, headers: Iterable[tuple[bytes, bytes]]) -> None:
        """Hand the connection to uvicorn's WebSocket; its phase is `asking` until the app marks it as `watching`."""
        self._to("asking")
        protocol_class: Any = self._config.ws_protocol_class
        self._socket = protocol_class(config=self._config, server_state=self._state, app_state={"connection": self})
        self._socket.connection_made(self.transport)
        lines = [b"%s %s HTTP/1.1" % (request.method, request.target), *(b"%s: %s" % header for header in headers)]
        self._socket.data_received(b"\r\n".join([*lines, b"", b""]))

    def _refuse(self) -> None:
        """Answer 400 to bytes that are not a request; the current request runs on and gets no other answer."""
        if self._exchange is not None:
            self._exchange.leave()
        with suppress(h11.LocalProtocolError):  # the error follows an answer that the sender has not read yet
            headers = [(b"content-type", b"text/plain; charset=utf-8"), CLOSE]
            self.write(h11.Response(status_code=400, headers=headers, reason=b"Bad Request"))
            self.write(h11.Data(data=BAD_REQUEST))
            self.write(h11.EndOfMessage())
        self.close()

    def _look(self) -> None:
        """Report the phase to the slot; the rest of a body after the answer counts as a head."""
        if self.is_closing:
            self._to("leaving")
        elif self._exchange is not None and not self._exchange.is_done:
            self._to(self._exchange.phase)
        else:
            is_unfinished = self._http.trailing_data[0] or self._http.their_state is h11.SEND_BODY
            self._to("head" if is_unfinished else "idle")

    def _to(self, phase: Phase) -> None:
        if self._slot is not None:
            self._slots.to(self._slot, phase, time.monotonic())


def connection_of(scope: Scope) -> Connection | None:
    """Return the connection of a request; None outside of a `Server`."""
    connection = scope.get("state", {}).get("connection")
    return connection if isinstance(connection, Connection) else None


def _origin_form(request: h11.Request) -> h11.Request:
    """Return a request in origin form if its target is in absolute form (RFC 9112, 3.2.2).

    A target with another host than the header stays as it is, and matches no route.
    """
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


def _asks_for_socket(headers: Iterable[tuple[bytes, bytes]]) -> bool:
    by_name = dict(headers)
    options = [option.strip().lower() for option in by_name.get(b"connection", b"").split(b",")]
    return b"upgrade" in options and by_name.get(b"upgrade", b"").lower() == b"websocket"


def _ends_doubtfully(headers: Iterable[tuple[bytes, bytes]]) -> bool:
    """Return whether a request states its length twice; a proxy may then misread where it ends (RFC 9112, 6.1)."""
    names = {name for name, _value in headers}
    return b"content-length" in names and b"transfer-encoding" in names


def _end(name: Any) -> tuple[str, int] | None:
    return (str(name[0]), int(name[1])) if name else None
