"""The WebSockets of viewers: who may open one, how many at once, and how each begins."""

import asyncio
from abc import abstractmethod
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress

from starlette.routing import BaseRoute, Match
from starlette.types import Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from lbr.apps.http import names
from lbr.apps.http.connection import connection_of
from lbr.apps.http.rates import Bucket
from lbr.apps.http.turns import Turns
from lbr.apps.web import routing
from lbr.apps.web.application import Gate
from lbr.apps.web.face import Client, Refused, refuse_without
from lbr.apps.web.guards import headers_of
from lbr.apps.web.routing import Path
from lbr.apps.web.sessions import Sessions

TOKEN_PROTOCOL = "bearer."  # noqa: S105 - browsers' scripts cannot set headers of a WebSocket
MOST_VIEWERS, MOST_OF_ONE = 16, 8
STALLED_S = 5.0
STALLED, TALKS = 1013, 1008
SIGNED_OUT = "signed out, or its token was revoked"


class Viewer:
    """The far end of a WebSocket. A subclass makes its frames, and may read its messages.

    `period_s`: the time between frames. More than `messages_hz` messages a second close it, with `too_much` as the
    reason. `last_messages_s`: how long messages are read after the end.
    """

    messages_hz, messages_at_once = 20.0, 20.0
    too_much = "messages are not read here"
    last_messages_s = 0.0

    def __init__(self, period_s: float) -> None:
        self.period_s = period_s
        self.is_known: Callable[[], bool] = lambda: True
        self._loop = asyncio.get_running_loop()
        self._woken = asyncio.Event()
        self._rate = Bucket(self.messages_hz, self._loop.time(), self.messages_at_once)

    @abstractmethod
    def frames(self) -> Iterator[str | bytes]:
        """Yield the frames that are due."""

    def receive(self, message: str | bytes) -> None:
        """Read one message; ignored by default."""

    def leave(self) -> None:
        """Release all that it has."""

    def wake(self) -> None:
        """End a rest."""
        self._woken.set()

    async def rest(self, seconds: float) -> None:
        """Wait that long, or until `wake`."""
        with suppress(TimeoutError):
            async with asyncio.timeout(max(seconds, 0.001)):
                await self._woken.wait()
        self._woken.clear()

    async def read(self, receive: Receive) -> str:
        """Read messages until the viewer leaves; return why it must be closed, or an empty string."""
        while True:
            message: Message = await receive()
            if message["type"] == "websocket.disconnect":
                return ""
            if not self.is_known():
                return SIGNED_OUT
            if not self._rate.take(self._loop.time()):
                return self.too_much
            text = message.get("text")
            self.receive(text if text is not None else message.get("bytes") or b"")

    async def serve(self, socket: WebSocket, receive: Receive) -> None:
        """Send and read until it is over. Reading has its own task, so that a viewer that stalls can still release."""
        reading = asyncio.create_task(self.read(receive))
        reading.add_done_callback(lambda _done: self.wake())
        try:
            code, reason = await self._send_frames(socket, reading)
        finally:
            self.leave()
            if self.last_messages_s:
                await asyncio.wait((reading,), timeout=self.last_messages_s)
            reading.cancel()
            with suppress(asyncio.CancelledError):
                await reading
        if code:
            async with asyncio.timeout(STALLED_S):
                await socket.close(code, reason[:120])

    async def _send_frames(self, socket: WebSocket, reading: "asyncio.Task[str]") -> tuple[int, str]:
        """Send frames until the viewer leaves (0), stalls, or must be closed; return the close code and the reason."""
        due = self._loop.time()
        while not reading.done():
            if not self.is_known():
                return TALKS, SIGNED_OUT
            try:
                async with asyncio.timeout(STALLED_S):
                    for frame in self.frames():
                        await (socket.send_text(frame) if isinstance(frame, str) else socket.send_bytes(frame))
            except TimeoutError:
                return STALLED, f"nothing was read for {STALLED_S:g} s"
            due = max(self._loop.time(), due + self.period_s)
            await self.rest(due - self._loop.time())
        return (TALKS, reason) if (reason := reading.result()) else (0, "")


class Viewing(BaseRoute):
    """The open WebSockets of one path, or of any; for the server's thread.

    `protocols`: its subprotocols, the best first. `does`: the activity of other clients, for a refusal. With
    `sessions`, the sockets of tokens and sessions that are not valid any more are closed.
    """

    path: Path | None = None
    protocols: tuple[str, ...]
    does = "looking"

    def __init__(self, gate: Gate, viewers: Turns, sessions: Sessions | None = None) -> None:
        self._gate = gate
        self._viewers = viewers
        self._sessions = sessions

    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        """Return whether a request is for a WebSocket of this path."""
        fits = scope["type"] == "websocket" and (self.path is None or self.path.fits(routing.asked_path(scope)))
        return (Match.FULL if fits else Match.NONE), {}

    async def handle(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one WebSocket; raise Refused."""
        headers = headers_of(scope)
        self._gate.refuse_strangers(scope, headers)
        client = await self.client(scope, headers)
        refuse_without(client, "view")
        if full := self._viewers.why_not(asker(client)):
            raise Refused(503, f"{full} are {self.does} already", {"Retry-After": "10"}, "busy")
        viewer = self.viewer(scope, client)
        socket = WebSocket(scope, receive, send)
        with self._viewers.turn(asker(client)), suppress(WebSocketDisconnect, OSError):
            await socket.accept(self.chosen(scope.get("subprotocols", ())))
            if (connection := connection_of(scope)) is not None:
                connection.mark("watching")
            viewer.is_known = lambda: self._sessions is None or not client.mark or self._sessions.knows(client.mark)
            await viewer.serve(socket, receive)

    def chosen(self, offered: Collection[str]) -> str | None:
        """Return the best subprotocol of an offer, or None; raise Refused."""
        return next((one for one in self.protocols if one in offered), None)

    async def client(self, scope: Scope, headers: Mapping[str, str]) -> Client:
        """Return the client; raise Refused."""
        return await self._gate.client(scope, headers, shown_token(scope))

    @abstractmethod
    def viewer(self, scope: Scope, client: Client) -> Viewer:
        """Return the viewer of a client; raise Refused."""


def shown_token(scope: Scope) -> str:
    """Return the token that a script sends as a subprotocol; empty without one."""
    offered = scope.get("subprotocols", ())
    return next((one.removeprefix(TOKEN_PROTOCOL) for one in offered if one.startswith(TOKEN_PROTOCOL)), "")


def asker(client: Client) -> str:
    """Return the owner by which viewers are counted."""
    return f"token {client.name}" if client.name else names.peer_name(client.address)
