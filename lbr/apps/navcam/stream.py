"""MJPEG: one response whose parts are pictures, each shown by a browser as soon as it is there.

A browser shows a part once it has read the header of the next. So that header follows each picture at once, which
makes a Content-Length of the part impossible and saves a whole interval of age.
"""

import asyncio
from contextlib import suppress

from starlette.types import Receive, Scope, Send

from lbr.apps.navcam.hub import Viewer

BOUNDARY = "FRAME"
PART = f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\n\r\n".encode()
HEADERS = (
    (b"age", b"0"),
    (b"cache-control", b"no-cache, private"),
    (b"pragma", b"no-cache"),
    (b"content-type", f"multipart/x-mixed-replace; boundary={BOUNDARY}".encode()),
)
STALLED_S = 10.0


async def stream(viewer: Viewer, scope: Scope, receive: Receive, send: Send) -> None:
    """Send a viewer's pictures until it hangs up, takes none for ten seconds, or there are no more."""
    if scope["method"] == "HEAD":
        viewer.end()
    gone = asyncio.create_task(_hung_up(viewer, receive))
    try:
        await _send(send, {"type": "http.response.start", "status": 200, "headers": list(HEADERS)})
        await _send(send, _body(PART))
        while (picture := await viewer.next()) is not None:
            await _send(send, _body(picture + b"\r\n" + PART))
            await _send(send, _body(b""))  # waits until the connection takes more; the picture after that is new
        await _send(send, {"type": "http.response.body", "body": b"", "more_body": False})
    except TimeoutError:
        viewer.end()  # and the server closes what was not completed
    finally:
        gone.cancel()
        with suppress(asyncio.CancelledError):
            await gone


def _body(data: bytes) -> dict[str, object]:
    return {"type": "http.response.body", "body": data, "more_body": True}


async def _send(send: Send, message: dict[str, object]) -> None:
    async with asyncio.timeout(STALLED_S):
        await send(message)


async def _hung_up(viewer: Viewer, receive: Receive) -> None:
    while (await receive())["type"] != "http.disconnect":
        pass
    viewer.end()
