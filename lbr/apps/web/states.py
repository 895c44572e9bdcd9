"""The robot's states for clients: one JSON object, encoded once for all of them."""

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
        "__doc__": """The newest states of the robot, null without a message or a wire; `age_s` has their ages.

    `faces` has each face's own state, such as its jobs.
    """
    },
)
"""The message of all states: each input under its name, the server's own and those of installed faces."""


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
