"""Whoever of a motion's chain is killed or hangs, the joints stop, and nothing goes on by itself afterwards."""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

from tests.support import programs
from tests.support.robot import Robot, prepare, running
from tests.support.waiting import HANG_S, until

pytestmark = [pytest.mark.slow_start]

POSES = ({"left_elbow": -0.5, "right_elbow": -1.5}, {"left_elbow": -1.5, "right_elbow": -0.5})
EDITS = (
    "UPDATE capability SET enabled = 0 WHERE robot = 'bioloid' AND name NOT IN ('servos', 'joints', 'motions')",
    "UPDATE capability SET kind = 'scripted_servos', settings = '{}' WHERE robot = 'bioloid' AND name = 'servos'",
    """UPDATE capability SET settings = '{"ttl_s": 1.0}' WHERE name IN ('joints', 'motions')""",
    "UPDATE joint SET speed_rps = 20",
    "INSERT INTO motion (robot, name) VALUES ('bioloid', 'swing')",
    *(
        f"""INSERT INTO motion_step (robot, motion, step, duration_s, positions)
        VALUES ('bioloid', 'swing', {step}, 0.5, '{json.dumps(pose)}')"""
        for step, pose in enumerate(POSES, 1)
    ),
    "INSERT INTO motion (robot, name) VALUES ('bioloid', 'stride')",
    """INSERT INTO motion_step (robot, motion, step, duration_s, stable, positions)
    SELECT robot, 'stride', step, 0.7, 1, positions FROM motion_step WHERE motion = 'swing'""",
)
PLAYER = """
import json, sys
from threading import Event
from lbr.bus import session, wire

bus = session.open_client(json.loads(sys.argv[1]))
def ask(**command):
    answers = wire.ask(bus, "bioloid/motions/play", json.loads(sys.argv[2]) | command, source="player", timeout_s=2.0)
    return json.loads(answers[0].payload) if answers else {"accepted": False}
reply = ask(take_over=True)
while reply.get("code") == "late":  # the machine held it up on its way: it is to be sent again
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
    with programs.start(arguments, stdout=subprocess.PIPE, text=True) as popen:
        assert popen.stdout is not None
        reply = json.loads(popen.stdout.readline())
        assert reply["accepted"], reply
        yield popen
        popen.kill()


@pytest.fixture
def player(robot):
    """Somebody with a process of its own who plays on and on; the joints swing."""
    until(lambda: robot.capability("motions")["phase"] == "ready", what="motions are there")
    until(lambda: robot.ask("joints/torque", {"on": True})["accepted"], what="torque is on")
    with plays(robot, motion="swing", times=100) as popen:
        until(lambda: swings(robot), what="the joints swing")
        yield popen


@contextmanager
def strides(robot: Robot) -> "Iterator[subprocess.Popen[str]]":
    """Play what says where it stands, and wait until it is on its way from there."""
    until(lambda: robot.capability("motions")["phase"] == "ready", what="motions are there")
    until(lambda: robot.ask("joints/torque", {"on": True})["accepted"], what="torque is on")
    with plays(robot, motion="stride", times=100) as popen:
        until(lambda: robot.ask("joints/state")["moving"] and not stands(robot), what="it is on its way")
        yield popen


def stands(robot: Robot) -> bool:
    """Say whether the joints are in one of the poses where it stands."""
    measured = {name: one["position_rad"] for name, one in robot.ask("joints/state")["joints"].items()}
    return any(all(abs(measured[name] - pose[name]) < 0.01 for name in pose) for pose in POSES)


def stepping(robot: Robot) -> bool:
    return robot.ask("joints/state")["feet_s"] is not None


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


def idle(robot: Robot) -> bool:
    """Say whether motions answer, and that nothing is played."""
    state = robot.ask("motions/state")
    return state is not None and not state["playing"]


def newest_result(robot: Robot) -> str:
    return str((robot.ask("motions/result") or {}).get("reason"))


def test_a_motion_is_played_to_its_end_and_what_the_joints_reached_they_hold(robot):
    assert "torque on first" in robot.ask("motions/play", {"motion": "swing"})["reason"]
    until(lambda: robot.ask("joints/torque", {"on": True})["accepted"], what="torque is on")
    with plays(robot, motion="swing", times=2, speed=3.0) as popen:
        assert popen.wait(HANG_S) == 0
    assert "'swing' was played 2 times to its end" in newest_result(robot)

    def measured() -> dict[str, float]:
        joints = robot.ask("joints/state")["joints"]
        return {name: joints[name]["position_rad"] for name in POSES[1]}

    until(lambda: measured() == pytest.approx(POSES[1], abs=0.06), what="the pose of its last step")
    assert phase(robot) == "following"
    assert stays(robot)


def test_a_killed_player_stops_the_motion_and_its_servos_are_left_to_the_driver(robot, player):
    halts = robot.ask("servos/state")["halt"]
    player.kill()
    until(lambda: robot.ask("servos/state")["halt"] > halts)
    until(lambda: phase(robot) == "holding")
    assert stays(robot)
    until(lambda: "lapsed" in newest_result(robot))
    assert phase(robot) == "holding"
    assert idle(robot)


def test_killed_motions_leave_their_servos_to_the_driver_and_do_not_go_on(robot, player):
    os.kill(robot.capability("motions")["pid"], signal.SIGKILL)
    until(lambda: phase(robot) == "holding")
    until(lambda: idle(robot))
    assert player.wait(HANG_S) is not None
    assert stays(robot)
    assert phase(robot) == "holding"


@pytest.mark.parametrize("part", ["motions", "joints"])
def test_what_is_frozen_loses_the_servos_and_thawed_it_does_not_go_on(robot, player, part):
    pid = robot.capability(part)["pid"]
    os.kill(pid, signal.SIGSTOP)
    try:
        until(lambda: phase(robot) == "holding")
    finally:
        with suppress(ProcessLookupError):  # the executive ends it as hung before long
            os.kill(pid, signal.SIGCONT)
    until(lambda: idle(robot))
    until(lambda: stays(robot), what="rest, long before the swings would be over")


def test_a_killed_driver_ends_the_motion_and_its_next_life_moves_nothing(robot, player):
    os.kill(robot.capability("servos")["pid"], signal.SIGKILL)
    until(lambda: "the servo driver (servos) is gone" in newest_result(robot))
    until(lambda: robot.capability("servos")["phase"] == "ready")
    until(lambda: robot.ask("servos/state") is not None)
    assert stays(robot)
    assert idle(robot)


def test_killed_joints_end_the_motion_and_what_starts_again_does_not_go_on(robot, player):
    os.kill(robot.capability("joints")["pid"], signal.SIGKILL)
    until(lambda: "joints operation" in newest_result(robot))
    until(lambda: phase(robot) == "holding")
    until(lambda: robot.capability("joints")["phase"] == "ready")
    assert stays(robot)
    assert phase(robot) == "holding"
    assert idle(robot)


def test_a_stop_in_mid_step_goes_on_to_where_it_stands(robot):
    with strides(robot):
        answers = [robot.ask("motions/stop"), robot.ask("joints/stop")]
        assert all(answer["accepted"] for answer in answers)
        until(lambda: not stepping(robot))
        until(lambda: stands(robot), what="the last of its way is read")
        assert stays(robot)
        assert phase(robot) == "following"


def test_a_killed_player_leaves_it_where_it_stands_and_to_the_driver(robot):
    with strides(robot) as player:
        player.kill()
        until(lambda: phase(robot) == "holding")
        assert stands(robot)
        assert stays(robot)
        assert "lapsed" in newest_result(robot)


def test_killed_motions_hold_in_mid_step_at_once(robot):
    with strides(robot):
        os.kill(robot.capability("motions")["pid"], signal.SIGKILL)
        until(lambda: phase(robot) == "holding")
        assert not stepping(robot)
        assert stays(robot)


def test_joints_that_are_killed_on_the_way_to_its_feet_leave_it_held_and_do_not_go_on(robot):
    with strides(robot):
        pid = robot.capability("joints")["pid"]
        robot.ask("joints/stop")
        os.kill(pid, signal.SIGKILL)
        until(lambda: phase(robot) == "holding")
        until(lambda: robot.capability("joints")["phase"] == "ready")
        assert stays(robot)
        assert phase(robot) == "holding"
        assert not stepping(robot)
