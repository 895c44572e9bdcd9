"""The first motion that a person may ask of each robot, at the very line that says it is ready."""

import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.support.robot import Robot, prepare, running
from tests.support.waiting import HANG_S, until

MOVERS = ("motors", "servos", "drive", "joints", "motions")
Ask = Callable[[Robot], str]


def line(text: str) -> Ask:
    """Return a line of the console, sent again while it comes late; it returns why that was refused, or nothing."""

    def ask(robot: Robot) -> str:
        answer = until(lambda: (said := robot.line(text))["reason_code"] != "late" and said)
        return "" if answer["code"] == 0 else f"{text}: {answer['reason_code']}: {answer['text']}"

    return ask


def motor(robot: Robot) -> str:
    """Ask for a motion of one servo by the UXA-90's own API; return why it was refused, or nothing."""
    try:
        with urllib.request.urlopen(f"{robot.web}/motor?id=23&position=100&torq=4", timeout=HANG_S):
            return ""
    except urllib.error.HTTPError as err:
        return f"GET /motor: {err.code}: {err.read().decode(errors='replace')}"


FIRST: dict[str, tuple[Ask, ...]] = {
    "lbr": (line("/r/0.2/0"), line("/t/30")),
    "bioloid": (line("/torque/on"),),
    "uxa90": (motor, line("/play/basic_motion")),
}


@contextmanager
def asked_at_ready(name: str, ask: Ask) -> Iterator[tuple[Robot, str, float]]:
    """Run a robot as it ships and ask it; yield it, why it refused, or nothing, and the milliseconds to the answer."""
    with tempfile.TemporaryDirectory(prefix="lbr-ready-") as place:
        home = prepare(Path(place) / "home", whole=True)
        with running(home, profile=f"{name}-sim") as robot:
            since = time.monotonic()
            degraded = {one: why for one, why in robot.ready["degraded"].items() if one in MOVERS}
            why = (
                ask(robot)
                if robot.ready["ready"] and not degraded
                else f"ready with {degraded or robot.ready['failed']}"
            )
            yield robot, why, (time.monotonic() - since) * 1e3
