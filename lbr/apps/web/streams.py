"""`/ws`: the newest states; a slow reader misses some, and costs no memory."""

from collections.abc import Iterator
from typing import Annotated

from msgspec import Meta, Struct
from starlette.types import Scope

from lbr.apps.http.turns import Turns
from lbr.apps.web import routing
from lbr.apps.web.application import Gate
from lbr.apps.web.face import Client
from lbr.apps.web.robot import Robot, Snapshot
from lbr.apps.web.routing import Path
from lbr.apps.web.states import States
from lbr.apps.web.viewing import Viewer, Viewing


class StreamParams(Struct, frozen=True, kw_only=True):
    """The greatest rate of states."""

    rate_hz: Annotated[float, Meta(ge=0.1, le=50.0)] = 20.0


class Streams(Viewing):
    """The viewers of states, each at its own rate."""

    path = Path("/ws")
    protocols = ("lbr.state",)

    def __init__(self, robot: Robot, states: States, gate: Gate, viewers: Turns) -> None:
        super().__init__(gate, viewers, robot.sessions)
        self._robot = robot
        self._states = states

    def viewer(self, scope: Scope, client: Client) -> Viewer:
        """Return the viewer at its rate; raise Refused."""
        del client
        params = routing.converted(routing.parameters(scope["query_string"]), StreamParams)
        return _StateViewer(1.0 / params.rate_hz, self._robot, self._states)


class _StateViewer(Viewer):
    def __init__(self, period_s: float, robot: Robot, states: States) -> None:
        super().__init__(period_s)
        self._robot = robot
        self._states = states
        self._sent: Snapshot | None = None

    def frames(self) -> Iterator[str]:
        snapshot, sent = self._robot.snapshot, self._sent
        if snapshot is not sent:
            self._sent = snapshot
            yield self._states.encoded(snapshot).decode()
