"""Signs of life of clients over HTTP, whose connections stay open while their programs are frozen."""

import asyncio
from collections.abc import Callable

import mcp_types as types
from mcp.shared.message import ServerMessageMetadata
from mcp_types.version import MODERN_PROTOCOL_VERSIONS

from lbr.apps.mcp.motion import PATIENCE_S, Pulse
from lbr.apps.mcp.server import Context

PING_S = 0.05


class Pings:
    """A client of an older protocol, which is pinged on the stream of its call."""

    patience_s = PATIENCE_S

    def __init__(self, ctx: Context) -> None:
        self._ctx = ctx

    def why_not(self) -> str:
        """Return an empty text: each client answers pings."""
        return ""

    async def follow(self, beat: Callable[[], None]) -> None:
        """Ping repeatedly, and beat at each answer."""
        metadata = ServerMessageMetadata(related_request_id=self._ctx.request_id)
        while True:
            await self._ctx.session.send_request(types.PingRequest(), types.EmptyResult, metadata=metadata)
            beat()
            await asyncio.sleep(PING_S)


class Rounds:
    """A client of the newest protocol, which receives no requests: its own ones (`server`) are its signs of life."""

    patience_s = 0.33
    """A client repeats its request within 0.25 s."""

    def __init__(self) -> None:
        self.beat: Callable[[], None] = lambda: None

    def why_not(self) -> str:
        """Return an empty text: each client repeats its request."""
        return ""

    async def follow(self, beat: Callable[[], None]) -> None:
        """Leave `beat` to the server, which receives the client's next request."""
        self.beat = beat
        await asyncio.Event().wait()


def pulse_of_http(ctx: Context) -> Pulse:
    """Return the signs of life of a request's client."""
    return Rounds() if ctx.protocol_version in MODERN_PROTOCOL_VERSIONS else Pings(ctx)
