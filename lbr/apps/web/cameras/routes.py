"""What the cameras answer over HTTP, wherever their pictures come from."""

from collections.abc import Callable, Mapping
from importlib import resources
from typing import Annotated, Any, Protocol

import msgspec
from msgspec import Meta, Struct
from starlette.responses import Response

from lbr.apps.web.cameras.hub import Deal, Hub
from lbr.apps.web.cameras.stream import MEDIA, Stream
from lbr.apps.web.face import HTML, Face, Refused, Request, Route, json, text
from lbr.messages.camera import CameraState

PREFIX = "camera_"
OLDEST_S = 1.0
"""An older picture is none: the camera may be off."""
SCRIPT, STYLE, JPEG = "text/javascript", "text/css", "image/jpeg"
SIGN_IN = {"WWW-Authenticate": 'Bearer realm="lbr"'}


class CameraParams(Struct, frozen=True, kw_only=True):
    """Which camera."""

    camera: Annotated[str, Meta(max_length=40, description="its name, such as rear; empty for the one that is on")] = ""
    at: Annotated[str, Meta(max_length=40, description="anything, so that a browser asks again")] = ""


class Source(Protocol):
    """A source of pictures. Coroutines run where handlers do; `begin` and `tell` on the server's thread."""

    async def states(self) -> Mapping[str, CameraState]:
        """Return how each camera is, by its short name."""

    async def snapshot(self, camera: str) -> bytes | None:
        """Return the newest picture of a camera, or of any; None if there is none that is fresh."""

    def step(self) -> None:
        """Do one round of work."""

    def begin(self, deal: Deal) -> Callable[[], None]:
        """Have pictures come, each to `deal` on the server's thread; return what ends that."""

    def knows(self, session: str) -> bool:
        """Say whether a session goes on."""

    def on_sign_out(self, then: Callable[[], None]) -> None:
        """Have something called, on the server's thread, whenever a user signs out."""

    def tell(self, text: str) -> None:
        """Write down who watches."""


class CamerasFace(Face):
    """The routes; all but the page to sign in are `private`: to be at a place does not let anybody see."""

    name = "cameras"

    def __init__(self, source: Source) -> None:
        self._source = source
        self._hub = Hub(source.begin)
        source.on_sign_out(lambda: self._hub.end(source.knows))

    def routes(self) -> list[Route]:
        """Return what it answers."""
        camera: dict[str, Any] = {"params": CameraParams, "private": True, "method": "GET"}
        part: dict[str, Any] = {"method": "GET", "summary": "", "hidden": True}
        no_picture = {503: "There is no picture now, or too many watch."}
        return [
            Route(
                method="GET", path="/index.html", handle=_page("index.html", HTML), summary="A page that shows the cameras",
                replies={200: HTML}, private=True, page=True, otherwise=_page("signin.html", HTML, 401, SIGN_IN),
            ),
            Route(
                path="/stream.mjpg", handle=self._stream, summary="Watch a camera (MJPEG), the newest pictures only",
                replies={200: MEDIA}, refuses={404: "There is no such camera.", **no_picture}, **camera,
            ),
            Route(
                path="/snapshot.jpg", handle=self._snapshot, summary="The newest picture", replies={200: JPEG},
                refuses=no_picture, **camera,
            ),
            Route(
                method="GET", path="/cameras", handle=self._states, summary="How each camera is", private=True,
                replies={200: dict[str, dict[str, Any]]},
            ),
            Route(path="/page.js", handle=_page("page.js", SCRIPT), replies={200: SCRIPT}, private=True, **part),
            Route(path="/page.css", handle=_page("page.css", STYLE), replies={200: STYLE}, role=None, page=True, **part),
            Route(path="/signin.js", handle=_page("signin.js", SCRIPT), replies={200: SCRIPT}, role=None, page=True, **part),
        ]  # fmt: skip

    def step(self, now: float) -> None:
        """Take in what came."""
        del now
        self._source.step()

    def close(self) -> None:
        """End the streams."""
        self._hub.close()

    async def _states(self, _request: Request) -> Response:
        states = await self._source.states()
        return json(
            {
                name: {"status": "on" if state.on else "off", **msgspec.structs.asdict(state)}
                for name, state in states.items()
            }
        )

    async def _snapshot(self, request: Request) -> Response:
        picture = await self._source.snapshot(request.params.camera)
        if picture is None:
            raise Refused(503, "there is no picture now: the camera is off, or away")
        return Response(picture, headers={"Cache-Control": "no-cache, private"}, media_type=JPEG)

    async def _stream(self, request: Request) -> Response:
        camera = request.params.camera
        there = await self._source.states() if camera else {}
        if camera and camera not in there:
            raise Refused(404, f"there is no such camera; there are {', '.join(there) or 'none'}")
        return Stream(self._hub, camera, request.client, self._source.tell)


def _page(
    name: str, media: str, status: int = 200, headers: Mapping[str, str] | None = None
) -> Callable[..., Response]:
    content = (resources.files("lbr.apps.web.cameras") / "pages" / name).read_text(encoding="utf-8")
    return lambda *_request: text(content, status, media, **dict(headers or {}))
