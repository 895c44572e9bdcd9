"""A stubborn sender: drives under a lease, and goes on whatever the answers are."""

import select
import threading
import time
from contextlib import suppress
from typing import Any

from lbr.errors import BusError
from tests.support.robot import Robot
from tests.support.waiting import HANG_S

NOT_BEGUN = frozenset({"late", "held", "stale_sensor", "not_armed", "no_setpoint", "unreachable"})
HELD_UP = NOT_BEGUN | {"lapsed", "dead_lease", "holder_gone"}
"""How a motion is refused, or ends, where a busy machine holds up who sends it, decides it or carries it out."""
POWER = 0.4
RENEW_S = 0.1


def accepted(robot: Robot, command: dict[str, Any], *, source: str = "bench", limit_s: float = HANG_S) -> str:
    """Send a drive command until it is accepted; return its lease."""
    end = time.monotonic() + limit_s
    while True:
        reply = robot.ask("drive/command", command, source=source)
        if reply is not None and reply["accepted"]:
            return str(reply["lease"])
        if time.monotonic() > end:
            raise AssertionError(f"the robot does not drive: {reply}")
        select.select([], [], [], 0.02)


class Mover:
    """Drives under a lease renewed at 10 Hz, and goes on renewing whatever the answers are, until told to cease."""

    def __init__(self, robot: Robot, angle_deg: float, *, power: float = POWER, source: str = "bench") -> None:
        self._robot = robot
        self._source = source
        self._command: dict[str, Any] = {"power": power, "angle_deg": angle_deg}
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._renew, daemon=True)
        self.lease = ""

    def start(self, limit_s: float = HANG_S) -> "Mover":
        """Send the command until it is accepted, then hold it."""
        self.lease = accepted(self._robot, self._command, source=self._source, limit_s=limit_s)
        self._thread.start()
        return self

    def cease(self) -> None:
        """Send no more."""
        self._over.set()
        self._thread.join()

    def _renew(self) -> None:
        while not self._over.wait(RENEW_S):
            with suppress(BusError, Exception):  # the bus may be what was killed
                self._robot.put("drive/command", self._command | {"lease": self.lease}, source=self._source)
