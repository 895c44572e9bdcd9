"""`/ws`: states as they come, the newest only: a slow reader misses some, and holds no memory for it."""

import asyncio
from contextlib import suppress
from typing import Annotated

from msgspec import Meta, Struct
from starlette.routing import BaseRoute, Match
from starlette.types import Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from lbr.apps.http import names, serving
from lbr.apps.http.turns import Turns
from lbr.apps.web import routing
from lbr.apps.web.application import Gate
from lbr.apps.web.face import Client, Refused, refuse_without
from lbr.apps.web.guards import headers_of
from lbr.apps.web.robot import Robot
from lbr.apps.web.routing import Path
from lbr.apps.web.states import States

PATH = Path("/ws")
PROTOCOL = "lbr.state"
TOKEN_PROTOCOL = "bearer."  # noqa: S105 - browsers' scripts cannot set headers of a WebSocket
MOST_VIEWERS, MOST_OF_ONE = 16, 8
STALLED_S = 5.0
MOST_TOLD_HZ = 20.0
GOING_AWAY, STALLED, TALKS = 1001, 1013, 1008


class StreamParams(Struct, frozen=True, kw_only=True):
    """How many states a second, at most."""

    rate_hz: Annotated[float, Meta(ge=0.1, le=50.0)] = 20.0


class Streams(BaseRoute):
    """The open WebSockets. All but `close` is for the server's thread."""

    def __init__(self, robot: Robot, states: States, gate: Gate, viewers: Turns) -> None:
        self._robot = robot
        self._states = states
        self._gate = gate
        self._viewers = viewers
        self._over = ""

    def close(self, why: str) -> None:
        """End all of them, and begin none; takes effect at each one's next state."""
        self._over = why

    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        """Say whether a WebSocket is asked for here."""
        fits = scope["type"] == "websocket" and PATH.fits(routing.asked_path(scope))
        return (Match.FULL if fits else Match.NONE), {}

    async def handle(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one WebSocket; raise Refused."""
        client, rate_hz = await self._entry(scope)
        socket = WebSocket(scope, receive, send)
        with self._viewers.taken(who(client)), suppress(WebSocketDisconnect, OSError):
            offered = scope.get("subprotocols", ())
            await socket.accept(PROTOCOL if PROTOCOL in offered else None)
            if (connection := serving.connection_of(scope)) is not None:
                connection.mark("watching")
            await self._stream(socket, receive, 1.0 / rate_hz)

    async def _entry(self, scope: Scope) -> tuple[Client, float]:
        """Return who looks and how often; raise Refused."""
        headers = headers_of(scope)
        self._gate.refuse_strangers(scope, headers)
        client = await self._gate.client(scope, headers, shown_token(scope))
        refuse_without(client, "view")
        params = routing.converted(routing.parameters(scope["query_string"]), StreamParams)
        if self._over:
            raise Refused(503, self._over, {"Retry-After": "2"})
        if full := self._viewers.why_not(who(client)):
            raise Refused(503, f"{full} are looking already", {"Retry-After": "10"}, "busy")
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


def shown_token(scope: Scope) -> str:
    """Return the token that a script offers as a subprotocol; empty without one."""
    offered = scope.get("subprotocols", ())
    return next((one.removeprefix(TOKEN_PROTOCOL) for one in offered if one.startswith(TOKEN_PROTOCOL)), "")


def who(client: Client) -> str:
    """Return whose viewers are counted together."""
    return f"token {client.name}" if client.name else names.who(client.address)


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
