"""Signs of life of a client over HTTP: its connection stays open while its program is frozen."""

import asyncio
from collections.abc import Callable

import mcp_types as types
from mcp.shared.message import ServerMessageMetadata
from mcp_types.version import MODERN_PROTOCOL_VERSIONS

from lbr.apps.mcp.motion import PATIENCE_S, Pulse
from lbr.apps.mcp.server import Context

PING_S = 0.05


class Pings:
    """A client of an older protocol: it is pinged on the stream of its call."""

    patience_s = PATIENCE_S

    def __init__(self, ctx: Context) -> None:
        self._ctx = ctx

    def why_not(self) -> str:
        """Return an empty text: each client answers pings."""
        return ""

    async def follow(self, beat: Callable[[], None]) -> None:
        """Ping again and again, and beat at each answer."""
        metadata = ServerMessageMetadata(related_request_id=self._ctx.request_id)
        while True:
            await self._ctx.session.send_request(types.PingRequest(), types.EmptyResult, metadata=metadata)
            beat()
            await asyncio.sleep(PING_S)


class Rounds:
    """A client of the newest protocol, which is asked for nothing: it shows that it lives by asking again (`server`)."""

    patience_s = 0.33
    """It asks again after 0.25 s at most."""

    def __init__(self) -> None:
        self.beat: Callable[[], None] = lambda: None

    def why_not(self) -> str:
        """Return an empty text: each client asks again."""
        return ""

    async def follow(self, beat: Callable[[], None]) -> None:
        """Leave `beat` to the server, which receives the next request of the client."""
        self.beat = beat
        await asyncio.Event().wait()


def pulse_of_http(ctx: Context) -> Pulse:
    """Return what shows that the client of a request lives."""
    return Rounds() if ctx.protocol_version in MODERN_PROTOCOL_VERSIONS else Pings(ctx)
