"""Whoever of a motion's chain is killed or hangs, the joints stop, and nothing goes on by itself afterwards."""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.robot import Robot, prepare, running, until

pytestmark = pytest.mark.timeout(30)

POSES = ({"left_elbow": -0.5, "right_elbow": -1.5}, {"left_elbow": -1.5, "right_elbow": -0.5})
EDITS = (
    "UPDATE capability SET enabled = 0 WHERE robot = 'bioloid' AND name NOT IN ('servos', 'joints', 'motions')",
    "UPDATE capability SET kind = 'scripted_servos', settings = '{}' WHERE robot = 'bioloid' AND name = 'servos'",
    "UPDATE joint SET speed_rps = 20",
    "INSERT INTO motion (robot, name) VALUES ('bioloid', 'swing')",
    *(
        f"""INSERT INTO motion_step (robot, motion, step, duration_s, positions)
        VALUES ('bioloid', 'swing', {step}, 0.5, '{json.dumps(pose)}')"""
        for step, pose in enumerate(POSES, 1)
    ),
)
PLAYER = """
import json, sys
from threading import Event
from lbr.bus import session, wire

bus = session.open_client(json.loads(sys.argv[1]))
def ask(**command):
    answers = wire.ask(bus, "bioloid/motions/play", json.loads(sys.argv[2]) | command, source="player", timeout_s=2.0)
    return json.loads(answers[0].payload)
reply = ask(take_over=True)
print(json.dumps(reply), flush=True)
while reply["accepted"]:
    Event().wait(0.1)
    reply = ask(lease=reply["lease"])
"""


@pytest.fixture(scope="module")
def robot():
    with tempfile.TemporaryDirectory(prefix="lbr-") as folder:
        home = prepare(Path(folder) / "h", "servos", "joints", "motions", edits=EDITS)
        (home / "capabilities").mkdir(mode=0o700)
        shutil.copy(Path(__file__).with_name("scripted_servos.py"), home / "capabilities")
        with running(home, profile="bioloid-sim") as started:
            until(lambda: all(unit["phase"] == "ready" for unit in started.status()["capabilities"]))
            yield started


@contextmanager
def plays(robot: Robot, **command: Any) -> "Iterator[subprocess.Popen[str]]":
    arguments = [sys.executable, "-c", PLAYER, json.dumps(robot.endpoints), json.dumps(command)]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True) as popen:
        assert popen.stdout is not None
        reply = json.loads(popen.stdout.readline())
        assert reply["accepted"], reply
        yield popen
        popen.kill()


@pytest.fixture
def player(robot):
    """Somebody with a process of its own who plays on and on; the joints swing."""
    until(lambda: robot.ask("joints/torque", {"on": True})["accepted"], what="torque is on")
    with plays(robot, motion="swing", times=100) as popen:
        until(lambda: swings(robot), what="the joints swing")
        yield popen


def angles(robot: Robot) -> dict[int, float]:
    return {servo["id"]: servo["position_rad"] for servo in robot.ask("servos/state")["servos"]}


def sweeps_on(robot: Robot, count: int) -> None:
    begun = robot.ask("servos/state")["sweep"]
    until(lambda: robot.ask("servos/state")["sweep"] >= begun + count)


def swings(robot: Robot) -> bool:
    before = angles(robot)
    sweeps_on(robot, 5)
    return angles(robot) != before


def stays(robot: Robot) -> bool:
    """Say whether nothing moves over what would be half of a swing."""
    before = angles(robot)
    sweeps_on(robot, 30)
    return angles(robot) == before


def phase(robot: Robot) -> str:
    return str(robot.ask("servos/state")["phase"])


def newest_result(robot: Robot) -> str:
    return str(robot.ask("motions/result")["reason"])


def test_a_motion_is_played_to_its_end_and_what_the_joints_reached_they_hold(robot):
    assert "torque on first" in robot.ask("motions/play", {"motion": "swing"})["reason"]
    until(lambda: robot.ask("joints/torque", {"on": True})["accepted"], what="torque is on")
    with plays(robot, motion="swing", times=2, speed=3.0) as popen:
        assert popen.wait(10.0) == 0
    assert "'swing' was played to its end, 2 times" in newest_result(robot)
    measured = robot.ask("joints/state")["joints"]
    assert {name: measured[name]["position_rad"] for name in POSES[1]} == pytest.approx(POSES[1], abs=0.06)
    assert phase(robot) == "following"
    assert stays(robot)


def test_a_killed_player_stops_the_motion_and_the_joints_hold(robot, player):
    halts = robot.ask("servos/state")["halt"]
    player.kill()
    until(lambda: robot.ask("servos/state")["halt"] > halts)
    assert stays(robot)
    assert "lapsed" in newest_result(robot)
    assert phase(robot) == "following"  # nobody is lost who had the joints: they hold for as long as there is power
    assert not robot.ask("motions/state")["playing"]


def test_killed_motions_leave_their_servos_to_the_driver_and_do_not_go_on(robot, player):
    os.kill(robot.capability("motions")["pid"], signal.SIGKILL)
    until(lambda: phase(robot) == "holding")
    until(lambda: robot.capability("motions")["phase"] == "ready" and not robot.ask("motions/state")["playing"])
    assert player.wait(5.0) is not None
    assert stays(robot)
    assert phase(robot) == "holding"


def test_frozen_motions_lose_the_joints_and_thawed_they_do_not_go_on(robot, player):
    pid = robot.capability("motions")["pid"]
    os.kill(pid, signal.SIGSTOP)
    try:
        until(lambda: phase(robot) == "holding")
    finally:
        os.kill(pid, signal.SIGCONT)
    until(lambda: not robot.ask("motions/state")["playing"])
    assert stays(robot)


def test_killed_joints_end_the_motion_and_what_starts_anew_does_not_go_on(robot, player):
    os.kill(robot.capability("joints")["pid"], signal.SIGKILL)
    until(lambda: "joints operation" in newest_result(robot))
    until(lambda: robot.capability("joints")["phase"] == "ready")
    assert stays(robot)
    assert phase(robot) == "holding"
    assert not robot.ask("motions/state")["playing"]
