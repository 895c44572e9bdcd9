"""The cameras of a robot by its local door: pictures while there are viewers, and what the bus knows at this moment."""

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
    """Asks the cameras; everything is on the server's thread, and what waits for the bus beside it."""

    def __init__(self, bus: Session, robot: str, source: str, sessions: Sessions) -> None:
        self._bus = bus
        self._robot = robot
        self._source = source
        self._sessions = sessions

    async def states(self) -> dict[str, CameraState]:
        """Return how each camera is, by its short name."""
        states = {}
        for raw in await asyncio.to_thread(self._asked, "state"):
            with suppress(MalformedError):
                states[name_in(raw.key)] = _states.decode(raw.payload)
        return dict(sorted(states.items()))

    async def snapshot(self, camera: str) -> bytes | None:
        """Return the newest picture of a camera, or of any; None if no fresh one came."""
        snapshots = [
            (stamp.sent_s(stamp.read(raw.attachment), raw.arrived), raw.payload)
            for raw in await asyncio.to_thread(self._asked, "frame")
            if camera in {"", name_in(raw.key)} and pictures.is_whole(raw.payload)
        ]
        at, picture = max(snapshots, default=(0.0, None))
        return picture if time.monotonic() - at <= OLDEST_S else None

    def step(self) -> None:
        """Pictures come by themselves."""

    def begin(self, deal: Deal) -> Callable[[], None]:
        """Have pictures come; the bus library's thread only wakes ours."""
        loop = asyncio.get_running_loop()

        def wake() -> None:
            with suppress(RuntimeError):  # the loop is closed already
                loop.call_soon_threadsafe(take)

        def take() -> None:
            for raw in feed.take():
                if pictures.is_whole(raw.payload):
                    deal(name_in(raw.key), raw.payload)

        feed = wire.Subscription(self._bus, f"{self._robot}/{PREFIX}$*/frame", depth=DEPTH, wake=wake)
        return feed.close

    def knows(self, session: str) -> bool:
        """Return whether a session goes on."""
        return self._sessions.knows(session)

    def on_sign_out(self, then: Callable[[], None]) -> None:
        """Have something called whenever a user signs out."""
        self._sessions.on_end.append(then)

    def tell(self, text: str) -> None:
        """Write a line to the log, with the time; a log that takes nothing does not keep viewers from watching."""
        with suppress(OSError):
            sys.stdout.write(f"{time.strftime('%Y-%m-%d %H:%M:%S')} {text}\n")
            sys.stdout.flush()

    def _asked(self, output: str) -> list[Any]:
        return probe.survey(self._bus, f"{self._robot}/{PREFIX}$*/{output}", source=self._source, timeout_s=ANSWER_S)
