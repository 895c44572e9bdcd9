"""The robot's states as everybody outside gets them: one JSON object, made once for all who look."""

from typing import Any

import msgspec
from msgspec import Struct

from lbr.apps.web.robot import Snapshot
from lbr.capability.context import Received
from lbr.messages.joints import JointsState, MotionsState
from lbr.messages.uxa90 import ControllerState


class State(Struct, frozen=True, kw_only=True):
    """What moves the robot as it was said last, null where nothing was said yet; `age_s` is how old that is now.

    `faces` is what each face adds, such as its jobs.
    """

    robot: str
    joints: JointsState | None = None
    motions: MotionsState | None = None
    controller: ControllerState | None = None
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
        heard: dict[str, Received | None] = {
            "joints": snapshot.joints,
            "motions": snapshot.motions,
            "controller": snapshot.controller,
        }
        return State(
            robot=self._robot,
            joints=snapshot.joints_state,
            motions=snapshot.motions_state,
            controller=snapshot.controller_state,
            age_s={name: round(last.age_s(snapshot.at), 3) for name, last in heard.items() if last is not None},
            faces=snapshot.faces,
        )
