"""The guards of every request before its route, as middleware, outermost first: `Answering`, `Limits`, `Hosts`."""

import asyncio
import sys
import time
import traceback
from collections import deque
from collections.abc import Callable

from starlette.requests import ClientDisconnect
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from lbr.apps.http import names
from lbr.apps.http.connection import connection_of
from lbr.apps.http.pages import ANY, Pages
from lbr.apps.http.rates import Rates
from lbr.apps.http.turns import Turns
from lbr.apps.web.face import Refused, json
from lbr.capability.border import border
from lbr.errors import told

LONGEST_URL = 4096
TOO_OFTEN_S = 0.25
"""The delay of a refusal for too many requests, so that a flood leaves time for those who stop the robot."""
_READ, CAME = "lbr.headers", "lbr.came"
SECURITY = {
    "content-security-policy": "default-src 'none'; img-src 'self' data:; script-src 'self'; style-src 'self'; "
    "connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'",
    "referrer-policy": "same-origin",
    "x-content-type-options": "nosniff",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}


class Counts:
    """The counts and reports of the server; its thread writes them, the loop reads them."""

    def __init__(self) -> None:
        self.requests = 0
        self.refused = 0
        self.news: deque[tuple[str, str, str]] = deque(maxlen=64)

    def tell(self, kind: str, text: str, level: str = "info") -> None:
        """Queue an event to publish."""
        self.news.append((kind, text, level))


class Answering:
    """Answers refused and broken requests, counts all, and adds the security headers for browsers."""

    def __init__(self, app: ASGIApp, *, pages: Pages, counts: Counts) -> None:
        self._app = app
        self._pages = pages
        self._counts = counts

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] not in {"http", "websocket"}:
            return
        self._counts.requests += 1
        scope[CAME] = time.monotonic()
        begun = False

        async def sealed(message: Message) -> None:
            nonlocal begun
            if message["type"] in {"http.response.start", "websocket.http.response.start"}:
                self._counts.refused += message["status"] >= 400
                self._seal(scope, message)
            begun = True
            await send(message)

        faults: list[Exception] = []
        try:
            with border(faults.append, ClientDisconnect, WebSocketDisconnect, Refused):
                await self._app(scope, receive, sealed)
        except (ClientDisconnect, WebSocketDisconnect):
            return
        except Refused as err:
            await _answer(err.response(), scope, receive, sealed, begun=begun)
        for fault in faults:
            traceback.print_exception(fault)
            sys.stderr.flush()
            asked = f"{scope.get('method', 'WebSocket')} {scope['path'][:80]}"
            self._counts.tell("web_fault", f"{asked}: {told(fault)}", "error")
            broken = json({"message": "this answer is broken; the robot's log has the reason", "code": "failed"}, 500)
            await _answer(broken, scope, receive, sealed, begun=begun)

    def _seal(self, scope: Scope, message: Message) -> None:
        headers = dict(SECURITY)
        origin = headers_of(scope).get("origin", "")
        if origin and self._pages.allows(origin):
            headers["access-control-allow-origin"] = ANY if self._pages.allows(ANY) else origin
            headers["access-control-expose-headers"] = "ETag, Reason-Code, Retry-After, WWW-Authenticate"
        if not self._pages.allows(ANY):
            headers["vary"] = "Origin"
        given = message.get("headers", ())
        said = {name for name, _ in given}
        more = [(name.encode(), value.encode()) for name, value in headers.items() if name.encode() not in said]
        message["headers"] = [*given, *more]


class Limits:
    """Refuses clients with too many requests a second or at once. Stops, known by `is_stop`, are never refused."""

    def __init__(self, app: ASGIApp, *, rates: Rates, is_stop: Callable[[Scope], bool]) -> None:
        self._app = app
        self._rates = rates
        self._is_stop = is_stop
        self._turns = Turns()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it (429, 503)."""
        if self._is_stop(scope):
            if (connection := connection_of(scope)) is not None:
                connection.mark("stopping")
            await self._app(scope, receive, send)
            return
        asker = names.peer_name(address_of(scope))
        if not self._rates.take(asker, time.monotonic()):
            await asyncio.sleep(TOO_OFTEN_S)
            raise Refused(429, "too many requests a second from this address", {"Retry-After": "1"})
        if scope["type"] == "websocket":
            await self._app(scope, receive, send)  # its own route bounds it
            return
        if busy := self._turns.why_not(asker):
            raise Refused(
                503, f"{busy} are being answered already", {"Retry-After": "1", "Connection": "close"}, "busy"
            )
        with self._turns.turn(asker):
            await self._app(scope, receive, send)


class Hosts:
    """Refuses (421) requests for another host, or by a name that may not mean this machine."""

    def __init__(self, app: ASGIApp, *, own: frozenset[str], where: str) -> None:
        self._app = app
        self._own = own
        self._where = where

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        here = names.is_loopback(address_of(scope))
        if not names.is_ours(headers_of(scope).get("host", ""), self._own, loopback=here):
            how = "localhost or 127.0.0.1" if here else "its address or its name"
            raise Refused(421, f"ask for this robot by {how}, or name this host {self._where}")
        if len(scope.get("raw_path") or b"/") + len(scope["query_string"]) > LONGEST_URL:
            raise Refused(414, f"an address may have {LONGEST_URL} characters")
        await self._app(scope, receive, send)


def headers_of(scope: Scope) -> dict[str, str]:
    """Return a request's headers by lower-case names, decoded once; repeated ones are joined by commas."""
    read: dict[str, str] | None = scope.get(_READ)
    if read is not None:
        return read
    headers: dict[str, str] = scope.setdefault(_READ, {})
    for name, value in scope["headers"]:
        key, said = name.decode("latin-1").lower(), value.decode("latin-1")
        headers[key] = f"{headers[key]}, {said}" if key in headers else said
    return headers


def address_of(scope: Scope) -> str:
    """Return the client's address."""
    client = scope.get("client")
    return str(client[0]) if client else ""


async def _answer(response: Response, scope: Scope, receive: Receive, send: Send, *, begun: bool) -> None:
    """Answer, unless an answer has begun: that one is cut off, and its reader notices."""
    if begun:
        return
    if scope["type"] == "websocket":
        await WebSocket(scope, receive, send).send_denial_response(response)
    else:
        await response(scope, receive, send)
