"""The service: receives the reports of robots, and lists them, both by token and by TLS only."""

import asyncio
import signal
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress

import msgspec
from starlette.applications import Starlette
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response
from starlette.routing import Route

from lbr.apps.http import listening, names, serving
from lbr.apps.http.rates import Rates
from lbr.apps.registry.asking import PATH
from lbr.apps.registry.book import MOST_ROBOTS, Book, Entry
from lbr.apps.registry.guests import Guests
from lbr.errors import InputError
from lbr.messages.unreadable import UNREADABLE

LARGEST_BYTES = 8192
REQUESTS_PER_S = 100.0
"""The most requests from one address, behind which there may be many robots."""


class Service:
    """The routes: `POST /api/robots` registers, `DELETE` leaves, and `GET` lists."""

    def __init__(self, guests: Guests, book: Book, clock: Callable[[], float] = time.monotonic) -> None:
        self._guests = guests
        self._book = book
        self._clock = clock
        self._rates = Rates(REQUESTS_PER_S)

    def application(self) -> Starlette:
        """Return the ASGI application."""
        return Starlette(routes=[Route(PATH, self._robots, methods=["GET", "POST", "DELETE"])])

    async def _robots(self, request: Request) -> Response:
        address, now = names.peer_name(request.client.host if request.client else ""), self._clock()
        if not self._rates.take(address, now):
            return _answer(429, "busy", "too many requests from there; wait a second")
        try:
            whose = self._guests.proven(_token_of(request))
            self._book.keep(self._guests.names())
        except InputError as err:
            return _answer(503, "failed", str(err))
        if not whose:
            return _answer(
                401, "token", "show a token: 'Authorization: Bearer TOKEN'; `lbr registry add NAME` makes one"
            )
        if request.method == "POST":
            return await self._registered(request, whose, address)
        if request.method == "DELETE":
            self._book.leave(whose)
            return _answer(200, "done", f"'{whose}' has left")
        return Response(msgspec.json.encode(self._book.listed(now)), media_type="application/json")

    async def _registered(self, request: Request, whose: str, address: str) -> Response:
        try:
            body = await request.body()
        except ClientDisconnect:
            return _answer(400, "malformed", "the request has no end")
        if len(body) > LARGEST_BYTES:
            return _answer(413, "malformed", f"a robot reports {LARGEST_BYTES} bytes at most, not {len(body)}")
        try:
            entry = msgspec.json.decode(body, type=Entry)
        except UNREADABLE as err:
            return _answer(400, "malformed", f"this registers no robot: {str(err)[:200]}")
        if not self._book.register(whose, address, entry, self._clock()):
            return _answer(503, "limit", f"{MOST_ROBOTS} robots are listed, and there is no room for one more")
        return _answer(200, "done", f"listed as '{whose}'")


def serve(host: str, port: int, say: Callable[[str], None]) -> None:
    """Serve until a signal; raise InputError if that is not possible."""
    guests = Guests()
    guests.names()
    with ExitStack() as stack:
        sockets = [stack.enter_context(one) for one in listening.listen(host, port)]
        server = serving.Server(Service(guests, Book()).application(), tls=True)
        signal.signal(signal.SIGTERM, _interrupt)
        say(f"the registry is at {names.origin(host, sockets[0].getsockname()[1])}")
        with suppress(KeyboardInterrupt):
            asyncio.run(server.serve(sockets=sockets))


def _interrupt(_number: int, _frame: object) -> None:
    raise KeyboardInterrupt


def _token_of(request: Request) -> str:
    scheme, _, shown = request.headers.get("authorization", "").partition(" ")
    return shown.strip() if scheme.lower() == "bearer" else ""


def _answer(status: int, code: str, reason: str) -> Response:
    body = {"accepted": code == "done", "code": code, "reason": reason}
    return Response(msgspec.json.encode(body), status, media_type="application/json")
