"""The robot's states as everybody outside gets them: one JSON object, made once for all who look."""

from typing import Any

import msgspec

from lbr.apps.web.kind import PORTS
from lbr.apps.web.robot import Snapshot

State = msgspec.defstruct(
    "State",
    [
        ("robot", str),
        *((name, PORTS.inputs[name] | None, None) for name in PORTS.states),
        ("age_s", dict[str, float], {}),
        ("faces", dict[str, Any], {}),
    ],
    frozen=True,
    kw_only=True,
    module=__name__,
    namespace={
        "__doc__": """What was said last of the robot, null where nothing was or is wired; `age_s` is how old that is now.

    `faces` is what each face adds, such as its jobs.
    """
    },
)
"""The inputs of states, each under its name: the server's own, and those that installed faces bring."""


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

    def state(self, snapshot: Snapshot) -> msgspec.Struct:
        """Return a snapshot as a message."""
        inputs = snapshot.inputs
        return State(
            robot=self._robot,
            age_s={name: round(last.age_s(snapshot.at), 3) for name, last in inputs.items()},
            faces=snapshot.faces,
            **{name: last.message for name, last in inputs.items()},
        )
