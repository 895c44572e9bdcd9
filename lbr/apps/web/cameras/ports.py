"""Pictures from the inputs of the capability `web`: of the cameras that channel rows wire to it."""

import asyncio
from collections.abc import Callable

from lbr.apps.web.cameras.hub import Deal
from lbr.apps.web.cameras.routes import OLDEST_S, PREFIX, CamerasFace
from lbr.apps.web.robot import Robot
from lbr.capability.context import Received
from lbr.messages.camera import CameraState

LOOK_S = 0.01
"""The pace at which the loop reads pictures while there are viewers; otherwise they stay unread in the bus library."""


class Ports:
    """The source of pictures. All but `begin`, `knows` and `tell` is for the capability's loop."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._states: dict[str, Received] = {}
        self._newest: dict[str, Received] = {}
        self._deal: Callable[[str, bytes], None] | None = None

    async def states(self) -> dict[str, CameraState]:
        """Return the state of each camera with a live process."""
        alive = {source: last for source, last in self._states.items() if self._robot.ctx.alive(source)}
        return {source.removeprefix(PREFIX): last.message for source, last in sorted(alive.items())}

    async def snapshot(self, camera: str) -> bytes | None:
        """Return the newest picture of the last second, or None."""
        self._look_for_pictures()
        fresh = [last for name, last in self._newest.items() if camera in {"", name} and self._is_fresh(last)]
        return max(fresh, key=lambda last: last.arrived).message.data if fresh else None

    def step(self) -> None:
        """Read states, and deal pictures if there are viewers."""
        for last in self._robot.ctx.take("cameras"):
            self._states[last.source] = last
        if self._deal is not None:
            self._look_for_pictures()
        self._newest = {name: last for name, last in self._newest.items() if self._is_fresh(last)}

    def begin(self, deal: Deal) -> Callable[[], None]:
        """Start reading pictures at a high rate; return the function that ends it."""
        loop = asyncio.get_running_loop()
        self._deal = lambda camera, picture: _soon(loop, deal, camera, picture)
        looking = loop.create_task(self._look())

        def end() -> None:
            self._deal = None
            looking.cancel()

        return end

    def knows(self, mark: str) -> bool:
        """Return whether a client's session or token is still valid."""
        return self._robot.sessions.knows(mark)

    def tell(self, text: str) -> None:
        """Publish an event."""
        self._robot.tell("watched", text)

    def _look_for_pictures(self) -> None:
        """Read new pictures, and show them to the viewers."""
        deal = self._deal
        for last in self._robot.ctx.take("frames"):
            camera = last.source.removeprefix(PREFIX)
            self._newest[camera] = last
            if deal is not None:
                deal(camera, last.message.data)

    def _is_fresh(self, last: Received) -> bool:
        return last.age_s(self._robot.now()) <= OLDEST_S

    async def _look(self) -> None:
        while True:
            self._robot.ctx.wake()
            await asyncio.sleep(LOOK_S)


def _soon(loop: asyncio.AbstractEventLoop, deal: Deal, camera: str, picture: bytes) -> None:
    if not loop.is_closed():
        loop.call_soon_threadsafe(deal, camera, picture)


def face(robot: Robot) -> CamerasFace:
    """Return the face."""
    return CamerasFace(Ports(robot))
