"""WebSockets of those who look at the robot: who may, how many at once, and how each begins."""

from abc import abstractmethod
from contextlib import suppress
from typing import Generic, TypeVar

from starlette.routing import BaseRoute, Match
from starlette.types import Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from lbr.apps.http import names
from lbr.apps.http.connection import connection_of
from lbr.apps.http.turns import Turns
from lbr.apps.web import routing
from lbr.apps.web.application import Gate
from lbr.apps.web.face import Client, Refused, refuse_without
from lbr.apps.web.routing import Path

W = TypeVar("W")
TOKEN_PROTOCOL = "bearer."  # noqa: S105 - browsers' scripts cannot set headers of a WebSocket
MOST_VIEWERS, MOST_OF_ONE = 16, 8
STALLED_S = 5.0
STALLED, TALKS = 1013, 1008


class Viewing(BaseRoute, Generic[W]):
    """The open WebSockets at a path; for the server's thread."""

    def __init__(self, path: Path, protocol: str, gate: Gate, viewers: Turns) -> None:
        self._path = path
        self._protocol = protocol
        self._gate = gate
        self._viewers = viewers

    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        """Say whether a WebSocket is asked for here."""
        fits = scope["type"] == "websocket" and self._path.fits(routing.asked_path(scope))
        return (Match.FULL if fits else Match.NONE), {}

    async def handle(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one WebSocket; raise Refused."""
        client, wanted = await self.entry(scope)
        socket = WebSocket(scope, receive, send)
        with self._viewers.turn(who(client)), suppress(WebSocketDisconnect, OSError):
            await socket.accept(self._protocol if self._protocol in scope.get("subprotocols", ()) else None)
            if (connection := connection_of(scope)) is not None:
                connection.mark("watching")
            await self.serve(socket, receive, client, wanted)

    @abstractmethod
    async def entry(self, scope: Scope) -> tuple[Client, W]:
        """Return the client, and its wish; raise Refused."""

    @abstractmethod
    async def serve(self, socket: WebSocket, receive: Receive, client: Client, wanted: W) -> None:
        """Serve a socket that was accepted, until it is over."""

    def refuse_viewer(self, client: Client) -> None:
        """Raise Refused for a client that may not look, and while there are too many."""
        refuse_without(client, "view")
        if full := self._viewers.why_not(who(client)):
            raise Refused(503, f"{full} are looking already", {"Retry-After": "10"}, "busy")


def shown_token(scope: Scope) -> str:
    """Return the token that a script offers as a subprotocol; empty without one."""
    offered = scope.get("subprotocols", ())
    return next((one.removeprefix(TOKEN_PROTOCOL) for one in offered if one.startswith(TOKEN_PROTOCOL)), "")


def who(client: Client) -> str:
    """Return whose viewers are counted together."""
    return f"token {client.name}" if client.name else names.peer_name(client.address)
