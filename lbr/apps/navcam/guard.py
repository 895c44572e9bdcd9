"""Who may see: who shows the token, by a header or by a cookie that the same user was given for it, and asks for us by name."""

import asyncio
import secrets
import time
from collections.abc import Iterable
from http.cookies import CookieError, SimpleCookie
from pathlib import Path

from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from lbr import home
from lbr.apps.http import names as hosts
from lbr.apps.http import peers, serving
from lbr.apps.http.pages import Pages, is_visit
from lbr.apps.http.rates import Rates
from lbr.apps.http.turns import Turns
from lbr.apps.navcam.sessions import LIFE_S, Sessions
from lbr.errors import InputError

TOKEN_FILE = "navcam.token"  # noqa: S105 - a file's name
REQUESTS_PER_S = 200.0
TOO_OFTEN_S = 0.25
WHOSE = "lbr.whose"
"""Where the guard writes who asks, for those behind it."""
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; img-src 'self' data:; script-src 'self'; style-src 'self'; "
    "connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
NO_TOKEN = (
    "Show the token: 'Authorization: Bearer TOKEN', or open the address that navcam printed in a browser. "
    f"It is in credentials/{TOKEN_FILE} of the robot's home.\n"
)


def token() -> str:
    """Return this home's token, made on first use; whoever removes its file locks everybody out."""
    (path,) = home.credentials(lambda: [secrets.token_urlsafe(32).encode()], TOKEN_FILE)
    return _read_private(path)


def _read_private(path: Path) -> str:
    text = path.read_text(errors="replace").strip()
    if len(text) < 32 or not text.isascii():
        raise InputError(f"{path} holds no token; remove it, and a new one is made")
    return text


class Lock:
    """Knows the token, compared in constant time, and the cookies that stand for it."""

    def __init__(self, secret: str, sessions: Sessions, *, port: int, tls: bool) -> None:
        self._secret = secret.encode()
        self._sessions = sessions
        self._name = f"{'__Host-' if tls else ''}lbr_navcam_{port}"
        self._tls = tls

    def opens(self, request: HTTPConnection) -> bool:
        """Say whether a request shows the token or a cookie."""
        return self.shows_token(request) or self.shows_cookie(request)

    def shows_cookie(self, request: HTTPConnection) -> bool:
        """Say whether a request shows the cookie of a session that goes on."""
        return self._sessions.knows(self.session(request))

    def shows_token(self, request: HTTPConnection) -> bool:
        """Say whether a request shows the token itself."""
        scheme, _, shown = request.headers.get("authorization", "").partition(" ")
        return scheme.lower() == "bearer" and secrets.compare_digest(shown.strip().encode(), self._secret)

    def give_cookie(self, request: HTTPConnection, response: Response) -> None:
        """Let a browser of the user who asks come in from now on without the token; none where the kernel knows no user."""
        whose = request.scope.get(WHOSE)
        if whose is None:
            return
        response.set_cookie(
            self._name,
            self._sessions.begin(whose),
            max_age=LIFE_S,
            path="/",
            httponly=True,
            samesite="strict",
            secure=self._tls,
        )

    def knows(self, session: str) -> bool:
        """Say whether a session goes on."""
        return self._sessions.knows(session)

    def take_cookie(self, request: HTTPConnection, response: Response, *, all_of_them: bool) -> None:
        """End the session whose cookie a request shows, or all there are."""
        if all_of_them:
            self._sessions.end_all()
        else:
            self._sessions.end(self.session(request))
        response.delete_cookie(self._name, path="/", httponly=True, samesite="strict", secure=self._tls)

    def session(self, request: HTTPConnection) -> str:
        """Return the mark of the session whose cookie a request shows, of the user who asks; empty without."""
        cookie, whose = self._cookie(request), request.scope.get(WHOSE)
        return self._sessions.mark(cookie, whose) if cookie and whose is not None else ""

    def _cookie(self, request: HTTPConnection) -> str:
        found: SimpleCookie = SimpleCookie()
        try:
            found.load(request.headers.get("cookie", ""))
        except CookieError:
            return ""
        return found[self._name].value if self._name in found else ""


class Guard:
    """Lets nobody pass without the token but to the `public` paths, nor whoever asks for another host."""

    def __init__(self, app: ASGIApp, *, lock: Lock, public: frozenset[str], names: Iterable[str]) -> None:
        self._app = app
        self._lock = lock
        self._public = public
        self._names = frozenset(name.lower() for name in names)
        self._pages = Pages()
        self._rates = Rates(REQUESTS_PER_S)
        self._turns = Turns()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer it."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        who = hosts.who(scope["client"][0] if scope.get("client") else "")
        if not self._rates.take(who, time.monotonic()):
            await asyncio.sleep(TOO_OFTEN_S)
            app: ASGIApp = PlainTextResponse("Too many requests a second.\n", 429, {"Retry-After": "1"})
        elif self._turns.why_not(who):
            app = PlainTextResponse("Too many requests at once.\n", 503, {"Retry-After": "1", "Connection": "close"})
        else:
            app = self._answer

        async def sealed(message: Message) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [
                    *message.get("headers", ()),
                    *((name.lower().encode(), value.encode()) for name, value in HEADERS.items()),
                ]
            await send(message)

        with self._turns.taken(who):
            await app(scope, receive, sealed)

    async def _answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, knowing whose program asks."""
        scope[WHOSE] = await _whose(scope)
        await self._answering(HTTPConnection(scope))(scope, receive, send)

    def _answering(self, request: HTTPConnection) -> ASGIApp:
        """Return what answers a request."""
        headers, address = request.headers, request.client.host if request.client else ""
        if not hosts.is_ours(", ".join(headers.getlist("host")), self._names, loopback=hosts.is_loopback(address)):
            text = "Ask for this robot by its address or name, at itself by localhost, or start navcam with --name.\n"
            return PlainTextResponse(text, 421)
        stranger = self._pages.stranger(headers, request.scope["scheme"])
        page = request.scope["path"] in {"/", "/index.html"}
        if stranger and not (page and is_visit(headers)):
            return PlainTextResponse("A page of somebody else's may not ask.\n", 403)
        if request.scope["path"] not in self._public and not self._lock.opens(request):
            return PlainTextResponse(NO_TOKEN, 401, {"WWW-Authenticate": 'Bearer realm="lbr navcam"'})
        return self._app


async def _whose(scope: Scope) -> str | None:
    """Return whose program asks; looked up once for a connection, beside the server's thread."""
    connection = serving.connection_of(scope)
    if connection is None:
        return None
    if connection.whose is None:
        whose = await asyncio.to_thread(peers.whose, scope["client"], scope["server"])
        connection.whose = whose if connection.is_held else None
    return connection.whose
