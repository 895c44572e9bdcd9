"""What the bus knows of the cameras at this moment. Blocks for half a second at most."""

import time
from typing import Any

import msgspec

from lbr.bus import pictures, probe, stamp
from lbr.bus.codec import Decoder
from lbr.bus.session import Session
from lbr.errors import MalformedError
from lbr.messages.camera import CameraState

ANSWER_S = 0.5
OLDEST_S = 1.0
PREFIX = "camera_"
_states = Decoder(CameraState)


def name_in(key: str) -> str:
    """Return a camera's short name from one of its keys."""
    return key.split("/")[-2].removeprefix(PREFIX)


class Cameras:
    """Asks the cameras of a robot; from any thread."""

    def __init__(self, bus: Session, robot: str, source: str) -> None:
        self._bus = bus
        self._robot = robot
        self._source = source

    def states(self) -> dict[str, dict[str, Any]]:
        """Return each camera's state by its short name, with `status` on or off."""
        found = {}
        for raw in self._asked("state"):
            try:
                state = _states.decode(raw.payload)
            except MalformedError:
                continue
            found[name_in(raw.key)] = {"status": "on" if state.on else "off", **msgspec.structs.asdict(state)}
        return dict(sorted(found.items()))

    def snapshot(self, camera: str = "") -> bytes | None:
        """Return the newest picture of a camera, or of any; None if there is none that is fresh."""
        taken = [
            (stamp.sent_s(stamp.read(raw.attachment), raw.arrived), raw.payload)
            for raw in self._asked("frame")
            if camera in {"", name_in(raw.key)} and pictures.is_whole(raw.payload)
        ]
        at, picture = max(taken, default=(0.0, None))
        return picture if time.monotonic() - at <= OLDEST_S else None

    def _asked(self, output: str) -> list[Any]:
        return probe.survey(self._bus, f"{self._robot}/{PREFIX}$*/{output}", source=self._source, timeout_s=ANSWER_S)
