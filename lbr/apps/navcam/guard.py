"""Who may see: whoever shows the token, by a header or by the cookie that was given for it, and asks for us by name."""

import secrets
from collections.abc import Iterable
from hashlib import blake2b
from http.cookies import CookieError, SimpleCookie
from pathlib import Path

from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from lbr import home
from lbr.apps.http.names import is_ours
from lbr.errors import InputError

TOKEN_FILE = "navcam.token"  # noqa: S105 - a file's name
COOKIE_S = 30 * 24 * 3600
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
    """Knows the token and the cookie that stands for it; compares in constant time."""

    def __init__(self, secret: str, *, port: int, tls: bool) -> None:
        self._secret = secret.encode()
        self._worth = blake2b(b"navcam cookie", key=self._secret[:64], digest_size=32).hexdigest()
        self._name = f"{'__Host-' if tls else ''}lbr_navcam_{port}"
        self._tls = tls

    def opens(self, request: HTTPConnection) -> bool:
        """Say whether a request shows the token or the cookie."""
        return self.shows_token(request) or self._shows_cookie(request)

    def shows_token(self, request: HTTPConnection) -> bool:
        """Say whether a request shows the token itself."""
        scheme, _, shown = request.headers.get("authorization", "").partition(" ")
        return scheme.lower() == "bearer" and secrets.compare_digest(shown.strip().encode(), self._secret)

    def give_cookie(self, response: Response) -> None:
        """Let a browser come in from now on without the token."""
        response.set_cookie(
            self._name, self._worth, max_age=COOKIE_S, path="/", httponly=True, samesite="strict", secure=self._tls
        )

    def _shows_cookie(self, request: HTTPConnection) -> bool:
        found: SimpleCookie = SimpleCookie()
        try:
            found.load(request.headers.get("cookie", ""))
        except CookieError:
            return False
        shown = found[self._name].value if self._name in found else ""
        return secrets.compare_digest(shown.encode(), self._worth.encode())


class Guard:
    """Lets nobody pass without the token but to the `public` paths, nor whoever asks for another host."""

    def __init__(self, app: ASGIApp, *, lock: Lock, public: frozenset[str], names: Iterable[str]) -> None:
        self._app = app
        self._lock = lock
        self._public = public
        self._names = frozenset(name.lower() for name in names)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer it."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        request = HTTPConnection(scope)
        app = self._app
        if not is_ours(request.headers.get("host", ""), self._names):
            app = PlainTextResponse("Ask for this robot by its address or name, or start navcam with --name.\n", 421)
        elif scope["path"] not in self._public and not self._lock.opens(request):
            app = PlainTextResponse(NO_TOKEN, 401, {"WWW-Authenticate": 'Bearer realm="lbr navcam"'})

        async def sealed(message: Message) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [
                    *message.get("headers", ()),
                    *((name.lower().encode(), value.encode()) for name, value in HEADERS.items()),
                ]
            await send(message)

        await app(scope, receive, sealed)
