"""A robot that runs as the service's user on devices of the kernel, and what becomes of it when one is pulled out."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.support import robot as robots
from tests.support.robot import Robot, only
from tests.support.usb.rig import ARDUINO, Rig, as_user, given_to, until

START_S = 300.0
"""On an emulated processor; a real one takes two seconds."""
READY_S = 60.0
ON_WHEELS = ("motors", "ranges", "drive")
ON_WHEELS_EDITS = (
    f"UPDATE device SET address = 'usb:2341:0043:{ARDUINO.serial}' WHERE robot = 'lbr' AND name = 'range_board'",
    "UPDATE capability SET settings = json_set(settings, '$.reply_timeout_s', 0.1) WHERE name = 'motors'",
)
"""The controller gets longer for its answers than a row allows by itself, since it is emulated beside the robot."""


@contextmanager
def running(user: str, home: Path, *names: str, edits: tuple[str, ...] = (), robot: str = "lbr") -> Iterator[Robot]:
    """Run a robot as a user, on devices as its rows have them: these capabilities of it alone."""
    robots.prepare(home, edits=(*edits, only(robot, *names)), whole=True)
    given_to(user, home)
    with robots.running(home, profile=robot, limit_s=START_S, prefix=as_user(user)) as found:
        yield found


def ready(robot: Robot, name: str, within_s: float = READY_S) -> float:
    """Wait until a capability is ready; return after how long."""
    return until(
        lambda: robot.capability(name)["phase"] == "ready", f"{name} ready: {robot.capability(name)}", within_s
    )


def degraded(robot: Robot, name: str, within_s: float = READY_S) -> tuple[float, str]:
    """Wait until a capability says what is wrong; return after how long, and what."""
    took = until(lambda: robot.capability(name)["phase"] != "ready", f"{name} tells", within_s)
    return took, robot.capability(name)["reason"]


class Outputs:
    """What the motors of an emulated controller do, as it is, not as it was told."""

    def __init__(self, rig: Rig) -> None:  # type: ignore[type-arg]
        self._twin = rig.twin.twin

    @property
    def now(self) -> tuple[float, float]:
        left, right = self._twin.wheels(time.monotonic())  # type: ignore[attr-defined]
        return left, right

    @property
    def zero(self) -> bool:
        return self.now == (0.0, 0.0)

    def wait(self, look: Callable[[], bool], what: str, within_s: float) -> float:
        return until(look, f"{what}; the outputs are {self.now}", within_s, every_s=0.002)
