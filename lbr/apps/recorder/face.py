"""The recordings made on purpose, for a page: their list, and each file."""

from pathlib import Path
from typing import Annotated

from msgspec import Struct
from starlette.responses import FileResponse, Response
from starlette.types import Receive, Scope, Send

from lbr import disk
from lbr.apps.http.connection import connection_of
from lbr.apps.http.turns import Turns
from lbr.apps.recorder.recording.shelf import Shelf, size_of
from lbr.apps.web.contract import Refuses
from lbr.apps.web.face import Client, Face, Refused, get
from lbr.apps.web.robot import Robot

MCAP = "application/octet-stream"
MOST_OF_ONE, MOST = 2, 6
NOT_NOW = Refuses({404: "There is no such recording.", 503: "Too many are saved at once."})


class Recording(Struct, frozen=True, kw_only=True):
    """A recording that has ended."""

    name: str
    bytes: int


class _Download(FileResponse):
    """A file to save. It may take long, so the connection has no deadline, and a client few at once."""

    def __init__(self, path: Path, client: Client, turns: Turns) -> None:
        super().__init__(path, media_type=MCAP, filename=path.name)
        self._client, self._turns = str(client), turns

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the file, or a refusal."""
        if full := self._turns.why_not(self._client):
            await Refused(503, f"{full} are saved at once, and no more", code="busy").response()(scope, receive, send)
            return
        if (connection := connection_of(scope)) is not None:
            connection.mark("watching")
        with self._turns.turn(self._client):
            await super().__call__(scope, receive, send)


class RecordingsFace(Face):
    """The routes. They require a `known` client, as those of the cameras do: a recording has pictures."""

    name = "recordings"

    def __init__(self, robot: Robot) -> None:
        self._shelf = Shelf(Path(robot.ctx.home), robot.name)
        self._turns = Turns(MOST_OF_ONE, MOST)

    @get("/recordings", role="known")
    async def _list(self) -> list[Recording]:
        """The recordings that have ended, the newest first."""
        return [Recording(name=path.name, bytes=size_of([path])) for path in reversed(self._ended())]

    @get("/recordings/{name}", role="known")
    async def _file(self, client: Client, name: str) -> Annotated[Response, MCAP, NOT_NOW]:
        """A recording, to save."""
        path = next((path for path in self._ended() if path.name == name), None)
        if path is None:
            raise Refused(404, f"there is no recording '{name[:80]}' that has ended", code="unknown_name")
        return _Download(path, client, self._turns)

    def _ended(self) -> list[Path]:
        return [path for path in self._shelf.recordings() if not disk.is_locked(path)]
