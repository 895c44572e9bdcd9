"""`/ws`: states as they come, the newest only: a slow reader misses some, and holds no memory for it."""

import asyncio
from contextlib import suppress
from typing import Annotated

from msgspec import Meta, Struct
from starlette.types import Message, Receive, Scope
from starlette.websockets import WebSocket

from lbr.apps.http.turns import Turns
from lbr.apps.web import routing
from lbr.apps.web.application import Gate
from lbr.apps.web.face import Client
from lbr.apps.web.guards import headers_of
from lbr.apps.web.robot import Robot
from lbr.apps.web.routing import Path
from lbr.apps.web.states import States
from lbr.apps.web.viewing import STALLED, STALLED_S, TALKS, Viewing, shown_token

PATH = Path("/ws")
PROTOCOL = "lbr.state"
MOST_TOLD_HZ = 20.0


class StreamParams(Struct, frozen=True, kw_only=True):
    """The greatest rate of states."""

    rate_hz: Annotated[float, Meta(ge=0.1, le=50.0)] = 20.0


class Streams(Viewing[float]):
    """Those that hear states, each so often."""

    def __init__(self, robot: Robot, states: States, gate: Gate, viewers: Turns) -> None:
        super().__init__(PATH, PROTOCOL, gate, viewers)
        self._robot = robot
        self._states = states

    async def entry(self, scope: Scope) -> tuple[Client, float]:
        """Return the viewer and its rate; raise Refused."""
        headers = headers_of(scope)
        self._gate.refuse_strangers(scope, headers)
        client = await self._gate.client(scope, headers, shown_token(scope))
        self.refuse_viewer(client)
        params = routing.converted(routing.parameters(scope["query_string"]), StreamParams)
        return client, params.rate_hz

    async def serve(self, socket: WebSocket, receive: Receive, client: Client, wanted: float) -> None:
        """Send states, so often, until it is over."""
        del client
        gone = asyncio.create_task(_heard_out(receive))
        try:
            code, why = await self._send_states(socket, gone, 1.0 / wanted)
        finally:
            gone.cancel()
            with suppress(asyncio.CancelledError):
                await gone
        if code:
            await socket.close(code, why[:120])

    async def _send_states(self, socket: WebSocket, gone: "asyncio.Task[str]", period_s: float) -> tuple[int, str]:
        """Send until the viewer goes (0), takes nothing, or talks too much; say why."""
        loop = asyncio.get_running_loop()
        due, sent = loop.time(), None
        while not gone.done():
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
