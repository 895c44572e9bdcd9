"""`/ws`: states as they come, the newest only: whoever reads slowly misses some, and holds no memory for it."""

import asyncio
from contextlib import suppress
from typing import Annotated

from msgspec import Meta, Struct
from starlette.responses import Response
from starlette.types import Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from lbr.apps.http.names import is_ours
from lbr.apps.web import routing
from lbr.apps.web.access import Access, Pages
from lbr.apps.web.application import Counts, headers_of, refusal
from lbr.apps.web.face import Client, Refused, refuse_without
from lbr.apps.web.robot import Robot
from lbr.apps.web.states import States

PATH = "/ws"
PROTOCOL = "lbr.state"
TOKEN_PROTOCOL = "bearer."  # noqa: S105 - browsers' scripts cannot set headers of a WebSocket
MOST_VIEWERS = 16
STALLED_S = 5.0
MOST_TOLD_HZ = 20.0
GOING_AWAY, STALLED, TALKS = 1001, 1013, 1008


class StreamParams(Struct, frozen=True, kw_only=True):
    """How many states a second, at most."""

    rate_hz: Annotated[float, Meta(ge=0.1, le=50.0)] = 20.0


class Streams:
    """The open WebSockets. All but `close` is for the server's thread."""

    def __init__(
        self, robot: Robot, states: States, access: Access, pages: Pages, names: frozenset[str], counts: Counts
    ) -> None:
        self._robot = robot
        self._states = states
        self._access = access
        self._pages = pages
        self._names = names
        self._counts = counts
        self._viewers = 0
        self._over = ""

    def close(self, why: str) -> None:
        """End all of them, and begin none; takes effect at each one's next state."""
        self._over = why

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one WebSocket, or refuse it with a status and a sentence."""
        if scope["type"] != "websocket":
            return
        socket = WebSocket(scope, receive, send)
        self._counts.requests += 1
        try:
            _client, rate_hz = self._entry(scope)
        except Refused as err:
            self._counts.refused += 1
            reply = refusal(err)
            with suppress(WebSocketDisconnect):
                await socket.send_denial_response(
                    Response(reply.body, reply.status, dict(reply.headers), media_type=reply.media)
                )
            return
        self._viewers += 1
        try:
            offered = scope.get("subprotocols", ())
            await socket.accept(PROTOCOL if PROTOCOL in offered else None)
            await self._stream(socket, receive, 1.0 / rate_hz)
        except (WebSocketDisconnect, OSError):
            return
        finally:
            self._viewers -= 1

    def _entry(self, scope: Scope) -> tuple[Client, float]:
        """Return who looks and how often; raise Refused."""
        headers = headers_of(scope)
        if scope["path"].lower().rstrip("/") != PATH:
            raise Refused(404, f"there is no WebSocket at {scope['path'][:80]}, but at {PATH}")
        if not is_ours(headers.get("host", ""), self._names):
            raise Refused(421, "ask for this robot by its address or its name")
        stranger = self._pages.stranger(headers, "https" if scope["scheme"] == "wss" else "http")
        if stranger:
            raise Refused(403, f"{stranger} may not ask; origins that may are the setting 'cors' of the row")
        tokens = [one for one in scope.get("subprotocols", ()) if one.startswith(TOKEN_PROTOCOL)]
        address = scope["client"][0] if scope.get("client") else ""
        client = self._access.client(address, headers, tokens[0].removeprefix(TOKEN_PROTOCOL) if tokens else "")
        refuse_without(client, "view")
        params = routing.converted(routing.parameters(scope["query_string"]), StreamParams)
        if self._over:
            raise Refused(503, self._over, {"Retry-After": "2"})
        if self._viewers >= MOST_VIEWERS:
            raise Refused(503, f"{MOST_VIEWERS} are looking already", {"Retry-After": "10"})
        return client, params.rate_hz

    async def _stream(self, socket: WebSocket, receive: Receive, period_s: float) -> None:
        gone = asyncio.create_task(_heard_out(receive))
        try:
            code, why = await self._send_states(socket, gone, period_s)
        finally:
            gone.cancel()
            with suppress(asyncio.CancelledError):
                await gone
        if code:
            await socket.close(code, why[:120])

    async def _send_states(self, socket: WebSocket, gone: "asyncio.Task[str]", period_s: float) -> tuple[int, str]:
        """Send until the viewer goes (0), takes nothing, talks too much, or the server ends; say why."""
        loop = asyncio.get_running_loop()
        due, sent = loop.time(), None
        while not gone.done():
            if self._over:
                return GOING_AWAY, self._over
            snapshot = self._robot.snapshot
            if snapshot is not sent:
                try:
                    async with asyncio.timeout(STALLED_S):
                        await socket.send_text(self._states.encoded(snapshot).decode())
                except TimeoutError:
                    return STALLED, f"nothing was read for {STALLED_S:g} s"
                sent = snapshot
            now = loop.time()
            due = max(now, due + period_s)
            await asyncio.wait([gone], timeout=max(due - now, 0.001))
        return (TALKS, why) if (why := gone.result()) else (0, "")


async def _heard_out(receive: Receive) -> str:
    """Return when the viewer has gone, or why it is to go: what it says is not listened to."""
    loop = asyncio.get_running_loop()
    since, count = loop.time(), 0
    while True:
        message: Message = await receive()
        if message["type"] == "websocket.disconnect":
            return ""
        count += 1
        if loop.time() - since > 1.0:
            since, count = loop.time(), 0
        if count > MOST_TOLD_HZ:
            return "nothing is to be said here"
