"""The robot's states as everybody outside gets them: one JSON object, made once for all who look."""

from typing import Any

import msgspec
from msgspec import Struct

from lbr.apps.web.robot import Snapshot
from lbr.messages.battery import BatteryState
from lbr.messages.drive import DriveState
from lbr.messages.joints import JointsState, MotionsState
from lbr.messages.sensing import Ranges
from lbr.messages.uxa90 import ControllerState

HEARD = ("joints", "motions", "controller", "drive", "ranges", "battery")
"""The inputs of states; `/state` has each under its name."""


class State(Struct, frozen=True, kw_only=True):
    """What was said last of the robot, null where nothing was or is wired; `age_s` is how old that is now.

    `faces` is what each face adds, such as its jobs.
    """

    robot: str
    joints: JointsState | None = None
    motions: MotionsState | None = None
    controller: ControllerState | None = None
    drive: DriveState | None = None
    ranges: Ranges | None = None
    battery: BatteryState | None = None
    age_s: dict[str, float] = {}
    faces: dict[str, Any] = {}


class States:
    """Encodes each snapshot once; for the server's thread alone."""

    def __init__(self, robot: str) -> None:
        self._robot = robot
        self._encoder = msgspec.json.Encoder()
        self._of: Snapshot | None = None
        self._text = b""

    def encoded(self, snapshot: Snapshot) -> bytes:
        """Return a snapshot as JSON."""
        if snapshot is not self._of:
            self._of, self._text = snapshot, self._encoder.encode(self.state(snapshot))
        return self._text

    def state(self, snapshot: Snapshot) -> State:
        """Return a snapshot as a message."""
        heard = {name: last for name in HEARD if (last := getattr(snapshot, name)) is not None}
        return State(
            robot=self._robot,
            age_s={name: round(last.age_s(snapshot.at), 3) for name, last in heard.items()},
            faces=snapshot.faces,
            **{name: last.message for name, last in heard.items()},
        )
