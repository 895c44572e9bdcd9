"""The recordings made on purpose, for a page: their list, and each file."""

from pathlib import Path
from typing import Annotated

from msgspec import Struct
from starlette.responses import FileResponse, Response
from starlette.types import Receive, Scope, Send

from lbr.apps.http.connection import connection_of
from lbr.apps.recorder.recording.segments import in_use
from lbr.apps.recorder.recording.shelf import Shelf, size_of
from lbr.apps.web.contract import Refuses
from lbr.apps.web.face import Face, Refused, get
from lbr.apps.web.robot import Robot

MCAP = "application/octet-stream"


class Recording(Struct, frozen=True, kw_only=True):
    """A recording that has ended."""

    name: str
    bytes: int


class _Download(FileResponse):
    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the file; it may take long, so the connection has no deadline."""
        if (connection := connection_of(scope)) is not None:
            connection.mark("watching")
        await super().__call__(scope, receive, send)


class RecordingsFace(Face):
    """The routes. They require a `known` client, as those of the cameras do: a recording has pictures."""

    name = "recordings"

    def __init__(self, robot: Robot) -> None:
        self._shelf = Shelf(Path(robot.ctx.home), robot.name)

    @get("/recordings", role="known")
    async def _list(self) -> list[Recording]:
        """The recordings that have ended, the newest first."""
        return [Recording(name=path.name, bytes=size_of([path])) for path in reversed(self._ended())]

    @get("/recordings/{name}", role="known")
    async def _file(self, name: str) -> Annotated[Response, MCAP, Refuses({404: "There is no such recording."})]:
        """A recording, to save."""
        path = next((path for path in self._ended() if path.name == name), None)
        if path is None:
            raise Refused(404, f"there is no recording '{name[:80]}' that has ended", code="unknown_name")
        return _Download(path, media_type=MCAP, filename=name)

    def _ended(self) -> list[Path]:
        return [path for path in self._shelf.recordings() if not in_use(path)]
