"""The cameras of a robot by its local door: pictures while there are viewers, and the newest states."""

import asyncio
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from lbr.apps.web.cameras.hub import Deal
from lbr.apps.web.cameras.routes import OLDEST_S, PREFIX
from lbr.apps.web.sessions import Sessions
from lbr.bus import pictures, probe, stamp, wire
from lbr.bus.codec import Decoder
from lbr.bus.session import Session
from lbr.errors import MalformedError
from lbr.messages.camera import CameraState

ANSWER_S = 0.5
DEPTH = 8
_states = Decoder(CameraState)


def name_in(key: str) -> str:
    """Return a camera's short name from one of its keys."""
    return key.split("/")[-2].removeprefix(PREFIX)


class Door:
    """Queries the cameras; all on the server's thread, and waits for the bus beside it."""

    def __init__(self, bus: Session, robot: str, source: str, sessions: Sessions) -> None:
        self._bus = bus
        self._robot = robot
        self._source = source
        self._sessions = sessions

    async def states(self) -> dict[str, CameraState]:
        """Return the state of each camera by its short name."""
        states = {}
        for raw in await asyncio.to_thread(self._asked, "state"):
            with suppress(MalformedError):
                states[name_in(raw.key)] = _states.decode(raw.payload)
        return dict(sorted(states.items()))

    async def snapshot(self, camera: str) -> bytes | None:
        """Return the newest picture of a camera, or of any; None without a fresh one."""
        snapshots = [
            (stamp.sent_s(stamp.read(raw.attachment), raw.arrived), raw.payload)
            for raw in await asyncio.to_thread(self._asked, "frame")
            if camera in {"", name_in(raw.key)} and pictures.is_whole(raw.payload)
        ]
        at, picture = max(snapshots, default=(0.0, None))
        return picture if time.monotonic() - at <= OLDEST_S else None

    def step(self) -> None:
        """Do nothing: pictures come by themselves."""

    def begin(self, deal: Deal) -> Callable[[], None]:
        """Subscribe to pictures; the bus library's thread only wakes ours."""
        loop = asyncio.get_running_loop()

        def wake() -> None:
            with suppress(RuntimeError):  # the loop is closed
                loop.call_soon_threadsafe(take)

        def take() -> None:
            for raw in feed.take():
                if pictures.is_whole(raw.payload):
                    deal(name_in(raw.key), raw.payload)

        feed = wire.Subscription(self._bus, f"{self._robot}/{PREFIX}$*/frame", depth=DEPTH, wake=wake)
        return feed.close

    def knows(self, mark: str) -> bool:
        """Return whether a client's session or token is still valid."""
        return self._sessions.knows(mark)

    def tell(self, text: str) -> None:
        """Write a dated line to the log; viewers may watch even if the log cannot be written."""
        with suppress(OSError):
            sys.stdout.write(f"{time.strftime('%Y-%m-%d %H:%M:%S')} {text}\n")
            sys.stdout.flush()

    def _asked(self, output: str) -> list[Any]:
        return probe.survey(self._bus, f"{self._robot}/{PREFIX}$*/{output}", source=self._source, timeout_s=ANSWER_S)
