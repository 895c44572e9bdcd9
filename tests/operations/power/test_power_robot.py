"""The whole way in real processes: the twin's voltage falls, the robot sits down, logind is asked, once."""

import json
import os
import shutil
import signal
import tempfile
from pathlib import Path

import pytest

from tests.operations.power.private_bus import Logind, needs_dbus
from tests.support.robot import prepare, running
from tests.support.waiting import until

pytestmark = [pytest.mark.slow_start, needs_dbus]
PARTS = ("servos", "joints", "motions", "ups", "power", "world")
SERVOS = Path(__file__).parents[1] / "motions" / "scripted_servos.py"


@pytest.fixture
def logind(tmp_path):
    logind = Logind(tmp_path)
    yield logind
    logind.finish()


@pytest.fixture
def robot(logind):
    power = {
        "device": "ups", "armed": True, "bus": logind.address,
        "hold_s": 0.0, "hold_samples": 2, "countdown_s": 0.3, "stale_s": 20.0, "park_s": 30.0, "let_go_s": 10.0,
    }  # fmt: skip
    edits = (
        f"UPDATE capability SET enabled = 0 WHERE robot = 'bioloid' AND name NOT IN {PARTS}",
        "UPDATE capability SET kind = 'scripted_servos', settings = '{}' WHERE robot = 'bioloid' AND name = 'servos'",
        f"UPDATE capability SET settings = '{json.dumps(power)}' WHERE robot = 'bioloid' AND name = 'power'",
        """UPDATE capability SET settings = '{"device": "ups", "pace_s": 0.02}' WHERE name = 'ups'""",
        """UPDATE capability SET settings = '{"ttl_s": 1.0}' WHERE name IN ('joints', 'motions')""",
        "UPDATE joint SET speed_rps = 20",
        "UPDATE motion_step SET duration_s = 0.5 WHERE motion = 'sit'",
    )
    with tempfile.TemporaryDirectory(prefix="lbr-") as folder:
        home = prepare(Path(folder) / "h", *PARTS, edits=edits)
        (home / "capabilities").mkdir(mode=0o700)
        shutil.copy(SERVOS, home / "capabilities")
        with running(home, profile="bioloid-sim") as started:
            until(lambda: all(unit["phase"] == "ready" for unit in started.status()["capabilities"]))
            yield started


def power(robot, field):
    return (robot.ask("power/state") or {}).get(field)


def sitting_down(robot):
    state = robot.ask("motions/state") or {}
    return (state.get("playing"), state.get("motion"), state.get("holder")) == (True, "sit", "power")


def standing_still(robot):
    return (robot.ask("motions/state") or {}).get("playing") is False


def accepted(robot, key, message):
    return (robot.ask(key, message) or {}).get("accepted")


def torques(robot):
    return [one["torque"] for one in (robot.ask("joints/state") or {"joints": {0: {"torque": 1}}})["joints"].values()]


def test_a_killed_shutdown_stops_the_motion_and_the_next_one_sits_down_and_powers_off_once(robot, logind):
    until(lambda: power(robot, "can_power_off") == "yes")
    until(lambda: accepted(robot, "joints/torque", {"on": True}), what="torque is on")
    assert robot.line("/fault/ups/external_v/9.5")["code"] == 0
    until(lambda: sitting_down(robot), what="it sits down")
    os.kill(robot.capability("power")["pid"], signal.SIGKILL)
    until(lambda: standing_still(robot), what="the motion stopped")
    assert "PowerOff" not in [name for name, _ in logind.calls]
    until(lambda: sitting_down(robot), what="it sits down again")
    until(lambda: power(robot, "phase") == "off", what="logind was asked")
    assert logind.calls.count(("PowerOff", [False])) == 1
    assert "PowerOff" not in [name for name, body in logind.calls if body != [False]]
    until(lambda: not any(torques(robot)), what="joints let go")
    assert power(robot, "phase") == "off"
    events = [event["kind"] for event in robot.events()]
    assert events.count("shutdown_agreed") == 1
