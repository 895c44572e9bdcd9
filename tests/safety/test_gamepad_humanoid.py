"""A humanoid plays its motions by a gamepad's buttons, while the dead-man button is held."""

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support import needs
from tests.support.robot import Robot, only, prepare, running
from tests.support.waiting import until

needs.modules("mujoco")

pytestmark = [pytest.mark.slow_start]
PAD = (
    only("bioloid", "world", "servos", "joints", "motions", "teleop"),
    "INSERT INTO device (robot, name, type, address) VALUES ('bioloid', 'pad', 'gamepad', '/dev/input/by-id/usb-pad')",
    "INSERT INTO capability (robot, name, kind, settings) VALUES ('bioloid', 'gamepad', 'gamepad', '{\"device\": \"pad\"}')",
    "UPDATE capability SET enabled = 1 WHERE robot = 'bioloid' AND name = 'teleop'",
)
LASTS_S = 1.0
"""Longer than any lease."""


@pytest.fixture(scope="module")
def bioloid() -> Iterator[Robot]:
    """The simulated Bioloid with its rows as they ship, and a gamepad."""
    with (
        tempfile.TemporaryDirectory(prefix="lbr-") as place,
        running(prepare(Path(place) / "h", edits=PAD), profile="bioloid-sim") as robot,
    ):
        until(lambda: robot.ask("teleop/state"), what="teleop tells")
        yield robot


def press(robot: Robot, buttons: str) -> None:
    assert robot.line(f"/fault/pad/pressed/{buttons}")["code"] == 0


def told(robot: Robot, **state: Any) -> None:
    def look() -> bool:
        found = robot.ask("teleop/state") or {}
        return all(found.get(name) == value for name, value in state.items())

    until(look, what=f"teleop says {state}")


def has_torque(robot: Robot) -> bool:
    joints = (robot.ask("joints/state") or {}).get("joints") or {}
    return bool(joints) and all(joint["torque"] > 0.0 for joint in joints.values())


def playing(robot: Robot) -> str:
    return str((robot.ask("motions/state") or {}).get("motion") or "")


def test_a_button_plays_a_motion_while_the_dead_man_button_is_held_and_its_release_ends_it(bioloid):
    press(bioloid, "off")
    told(bioloid, pad=True, dead_man=False)
    press(bioloid, "y")
    time.sleep(LASTS_S)
    assert playing(bioloid) == "", "without the dead-man button"
    press(bioloid, "tl")
    told(bioloid, dead_man=True)
    press(bioloid, "tl,start")
    until(lambda: has_torque(bioloid), what="its joints have torque")
    press(bioloid, "tl,y")
    until(lambda: playing(bioloid) == "wave", what="it waves")
    time.sleep(LASTS_S)
    assert playing(bioloid) == "wave", "it is renewed"
    press(bioloid, "off")
    until(lambda: playing(bioloid) == "", what="it ends")
    told(bioloid, line="")
