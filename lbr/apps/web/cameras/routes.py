"""The routes of the cameras over HTTP, for any source of pictures."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Protocol

import msgspec
from msgspec import Meta, Struct
from starlette.responses import Response

from lbr.apps.web.cameras.hub import Deal, Hub
from lbr.apps.web.cameras.stream import MEDIA, Stream
from lbr.apps.web.contract import Refuses
from lbr.apps.web.face import HTML, SCRIPT, STYLE, Client, Face, Refused, Route, get, static
from lbr.messages.camera import CameraState

PREFIX = "camera_"
OLDEST_S = 1.0
"""The age at which a picture no longer counts: the camera may be off."""
HERE, JPEG = "lbr.apps.web.cameras", "image/jpeg"
NO_PICTURE = Refuses({503: "There is no picture now, or too many watch."})
SIGN_IN = 'Bearer realm="lbr"'


class CameraParams(Struct, frozen=True, kw_only=True):
    """Which camera."""

    camera: Annotated[str, Meta(max_length=40, description="its name, such as rear; empty for the one that is on")] = ""
    at: Annotated[str, Meta(max_length=40, description="anything, so that a browser asks again")] = ""


class Source(Protocol):
    """A source of pictures. Coroutines run in the loop of handlers, `begin` and `tell` on the server's thread."""

    async def states(self) -> Mapping[str, CameraState]:
        """Return the state of each camera by its short name."""

    async def snapshot(self, camera: str) -> bytes | None:
        """Return the newest picture of a camera, or of any; None without a fresh one."""

    def step(self) -> None:
        """Do one round of work."""

    def begin(self, deal: Deal) -> Callable[[], None]:
        """Start the pictures, each to `deal` on the server's thread; return the function that ends them."""

    def knows(self, mark: str) -> bool:
        """Return whether a client's session or token is still valid."""

    def tell(self, text: str) -> None:
        """Report who watches."""


class SignIn(Route):
    """A page for known clients; others receive the sign-in page."""

    def refused(self, err: Refused) -> Response:
        """Return the sign-in page for an unknown client, else the refusal."""
        if err.status != 401:
            return err.response()
        return static(HERE, "signin.html", HTML, 401, WWW_Authenticate=SIGN_IN)


class CamerasFace(Face):
    """The routes. All but the sign-in page require a `known` client; a trusted address is not enough."""

    name = "cameras"

    def __init__(self, source: Source) -> None:
        self._source = source
        self._hub = Hub(source.begin, source.knows)

    def step(self, now: float) -> None:
        """Read states and pictures."""
        del now
        self._source.step()

    def close(self) -> None:
        """End the streams."""
        self._hub.close()

    @get("/index.html", SignIn, role="known", page=True)
    def _index(self) -> Annotated[Response, HTML]:
        """A page that shows the cameras."""
        return static(HERE, "index.html")

    @get("/stream.mjpg", role="known")
    async def _stream(
        self, client: Client, params: CameraParams
    ) -> Annotated[Response, MEDIA, Refuses({404: "There is no such camera."} | NO_PICTURE)]:
        """Watch a camera (MJPEG), the newest pictures only."""
        camera = params.camera
        there = await self._source.states() if camera else {}
        if camera and camera not in there:
            raise Refused(404, f"there is no such camera; there are {', '.join(there) or 'none'}")
        return Stream(self._hub, camera, client, self._source.tell)

    @get("/snapshot.jpg", role="known")
    async def _snapshot(self, params: CameraParams) -> Annotated[Response, JPEG, NO_PICTURE]:
        """The newest picture."""
        picture = await self._source.snapshot(params.camera)
        if picture is None:
            raise Refused(503, "there is no picture now: the camera is off, or away")
        return Response(picture, headers={"Cache-Control": "no-cache, private"}, media_type=JPEG)

    @get("/cameras", role="known")
    async def _states(self) -> dict[str, dict[str, Any]]:
        """The state of each camera."""
        states = await self._source.states()
        return {
            name: {"status": "on" if state.on else "off", **msgspec.structs.asdict(state)}
            for name, state in states.items()
        }

    @get("/page.js", role="known")
    def _page_js(self) -> Response:
        return static(HERE, "page.js", SCRIPT)

    @get("/page.css", role=None, page=True)
    def _page_css(self) -> Response:
        return static(HERE, "page.css", STYLE)

    @get("/signin.js", role=None, page=True)
    def _signin_js(self) -> Response:
        return static(HERE, "signin.js", SCRIPT)
