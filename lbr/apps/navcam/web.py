"""What navcam answers over HTTP."""

import asyncio
import sys
import time
from collections.abc import Awaitable, Callable, Iterable
from contextlib import suppress
from importlib import resources

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, RedirectResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp, Receive, Scope, Send

from lbr.apps.http import names, serving
from lbr.apps.navcam.cameras import Cameras
from lbr.apps.navcam.guard import Guard, Lock
from lbr.apps.navcam.hub import Hub
from lbr.apps.navcam.stream import stream

NEVER_KEPT = {"Cache-Control": "no-store"}
PAGES = {"page.js": "text/javascript", "signin.js": "text/javascript", "page.css": "text/css"}
PUBLIC = frozenset({"/", "/index.html", "/session", "/signin.js", "/page.css"})


class NavCam:
    """The answers to requests."""

    def __init__(self, hub: Hub, cameras: Cameras, lock: Lock) -> None:
        self._hub = hub
        self._cameras = cameras
        self._lock = lock
        self._index, self._signin = _page("index.html"), _page("signin.html")

    def app(self, own_names: Iterable[str] = ()) -> ASGIApp:
        """Return all of it behind the guard, for whoever asks for this machine by its address or a name of its own."""
        routes = [
            Route("/", _to_index),
            Route("/index.html", self._page),
            Route("/session", self._session, methods=["POST"]),
            Route("/session", self._sign_out, methods=["DELETE"]),
            Route("/sessions", self._sign_out, methods=["DELETE"]),
            Route("/stream.mjpg", _Stream(self._hub, self._cameras, self._lock), methods=["GET", "HEAD"]),
            Route("/snapshot.jpg", self._snapshot),
            Route("/cameras", self._states),
            *(Route(f"/{name}", _static(name, kind)) for name, kind in PAGES.items()),
        ]
        return Guard(Starlette(routes=routes), lock=self._lock, public=PUBLIC, names=own_names)

    async def _page(self, request: Request) -> Response:
        """Return the page; to whoever has no token yet, the one that takes it."""
        if self._lock.opens(request):
            return Response(self._index, headers=NEVER_KEPT, media_type="text/html")
        headers = {**NEVER_KEPT, "WWW-Authenticate": 'Bearer realm="lbr navcam"'}
        return Response(self._signin, 401, headers, media_type="text/html")

    async def _session(self, request: Request) -> Response:
        """Give a cookie for the token."""
        if not self._lock.shows_token(request):
            return PlainTextResponse("This is not the token.\n", 401, NEVER_KEPT)
        response = Response(status_code=204, headers=NEVER_KEPT)
        self._lock.give_cookie(request, response)
        return response

    async def _sign_out(self, request: Request) -> Response:
        """End the session of the cookie that is shown, or every session, and the streams that go by them."""
        response = Response(status_code=204, headers=NEVER_KEPT)
        self._lock.take_cookie(request, response, all_of_them=request.url.path == "/sessions")
        self._hub.end(self._lock.knows)
        return response

    async def _snapshot(self, request: Request) -> Response:
        picture = await asyncio.to_thread(self._cameras.snapshot, request.query_params.get("camera", ""))
        if picture is None:
            return PlainTextResponse("There is no picture now: the camera is off, or away.\n", 503, NEVER_KEPT)
        return Response(picture, headers={"Cache-Control": "no-cache, private"}, media_type="image/jpeg")

    async def _states(self, _request: Request) -> Response:
        return JSONResponse(await asyncio.to_thread(self._cameras.states), headers=NEVER_KEPT)


class _Stream:
    """An endpoint of its own, because what Starlette streams by itself cannot leave out pictures."""

    def __init__(self, hub: Hub, cameras: Cameras, lock: Lock) -> None:
        self._hub = hub
        self._cameras = cameras
        self._lock = lock

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        request = Request(scope)
        camera = request.query_params.get("camera", "")
        there = await asyncio.to_thread(self._cameras.states) if camera else {}
        if camera and camera not in there:
            text = f"There is no such camera; there are {', '.join(there) or 'none'}.\n"
            await PlainTextResponse(text, 404, NEVER_KEPT)(scope, receive, send)
            return
        who, what = request.client.host if request.client else "", camera or "the camera that is on"
        if full := self._hub.full(names.who(who)):
            text = f"{full} are watching already; come back when one has left.\n"
            await PlainTextResponse(text, 503, {**NEVER_KEPT, "Retry-After": "10"})(scope, receive, send)
            return
        tell(f"{who} watches {what}")
        if (connection := serving.connection_of(scope)) is not None:
            connection.mark("watching")
        session = "" if self._lock.shows_token(request) else self._lock.session(request)
        try:
            with self._hub.viewer(camera, names.who(who), session) as viewer:
                await stream(viewer, scope, receive, send)
        finally:
            tell(f"{who} watches {what} no more")


async def _to_index(_request: Request) -> Response:
    return RedirectResponse("/index.html", 301)


def _static(name: str, kind: str) -> Callable[[Request], Awaitable[Response]]:
    content = _page(name)

    async def answer(_request: Request) -> Response:
        return Response(content, headers=NEVER_KEPT, media_type=kind)

    return answer


def tell(text: str) -> None:
    """Write a line to the log, with the time; a log that takes nothing keeps nobody from watching."""
    with suppress(OSError):
        sys.stdout.write(f"{time.strftime('%Y-%m-%d %H:%M:%S')} {text}\n")
        sys.stdout.flush()


def _page(name: str) -> bytes:
    return (resources.files("lbr.apps.navcam") / "pages" / name).read_bytes()
