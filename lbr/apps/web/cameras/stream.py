"""MJPEG: one response of many pictures, each shown by a browser as soon as it is received.

A browser shows a picture once it has read the next part's header. So that header follows each picture at once. This
saves one interval of age, and rules out a Content-Length.
"""

import asyncio
from collections.abc import Callable
from contextlib import suppress

from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from lbr.apps.http import names
from lbr.apps.http.connection import connection_of
from lbr.apps.web.cameras.hub import Hub, Viewer
from lbr.apps.web.face import Client, Refused

BOUNDARY = "FRAME"
MEDIA = "multipart/x-mixed-replace"
PART = f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\n\r\n".encode()
HEADERS = (
    (b"age", b"0"),
    (b"cache-control", b"no-cache, private"),
    (b"pragma", b"no-cache"),
    (b"content-type", f"{MEDIA}; boundary={BOUNDARY}".encode()),
)
STALLED_S = 10.0


class Stream(Response):
    """Streams a camera (empty: the active one) until its viewer hangs up or stalls, or the pictures end."""

    def __init__(self, hub: Hub, camera: str, client: Client, tell: Callable[[str], None]) -> None:
        super().__init__()
        self._hub = hub
        self._camera = camera
        self._client = client
        self._tell = tell

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the newest pictures; raise Refused (503) if too many watch."""
        asker, name = names.peer_name(self._client.address), self._camera or "the camera that is on"
        if full := self._hub.full(asker):
            text = f"{full} are watching already; come back when one has left"
            raise Refused(503, text, {"Retry-After": "10"}, "busy")
        self._tell(f"{self._client} watches {name}")
        if (connection := connection_of(scope)) is not None:
            connection.mark("watching")
        try:
            with self._hub.viewer(self._camera, asker, self._client.mark) as viewer:
                await _stream(viewer, scope, receive, send)
        finally:
            self._tell(f"{self._client} watches {name} no more")


async def _stream(viewer: Viewer, scope: Scope, receive: Receive, send: Send) -> None:
    if scope["method"] == "HEAD":
        viewer.end()
    hang_up = asyncio.create_task(_hung_up(viewer, receive))
    try:
        await _send(send, {"type": "http.response.start", "status": 200, "headers": list(HEADERS)})
        await _send(send, _body(PART))
        while (picture := await viewer.next()) is not None:
            await _send(send, _body(picture + b"\r\n" + PART))
            await _send(send, _body(b""))  # waits until the connection takes more; the picture after that is new
        await _send(send, {"type": "http.response.body", "body": b"", "more_body": False})
    except TimeoutError:
        viewer.end()  # and the server closes the incomplete response
    finally:
        hang_up.cancel()
        with suppress(asyncio.CancelledError):
            await hang_up


def _body(data: bytes) -> dict[str, object]:
    return {"type": "http.response.body", "body": data, "more_body": True}


async def _send(send: Send, message: dict[str, object]) -> None:
    async with asyncio.timeout(STALLED_S):
        await send(message)


async def _hung_up(viewer: Viewer, receive: Receive) -> None:
    while (await receive())["type"] != "http.disconnect":
        pass
    viewer.end()
