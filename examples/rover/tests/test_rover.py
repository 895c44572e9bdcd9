"""The whole rover in simulation: it drives, turns, stops, measures its way, and obeys its lidar."""

import subprocess
import sys
from contextlib import suppress
from math import cos, dist, pi, sin

import pytest

from lbr.testing import robot as robots
from lbr.testing.robot import NoAnswerError, running

NAMES = ("motors", "lidar", "imu", "drive", "attitude", "odometry", "world", "web")
PATIENT = {"ttl_s": 1.0}
"""A test on a busy machine may be late to renew its lease."""
SENDER = """
import json, sys, time
from lbr.bus import session, wire
bus, lease = session.open_client(sys.argv[1:]), ""
while True:
    twist = {"vx_mps": -0.15, "lease": lease}
    for answer in wire.ask(bus, "rover/drive/twist", twist, source="sender", timeout_s=2.0):
        lease = json.loads(answer.payload).get("lease", "")
    time.sleep(0.1)
"""
"""Drives back for as long as it lives."""
PATIENTLY = (
    "UPDATE capability SET settings = json_set(settings, '$.setpoint_valid_s', 0.25, '$.watchdog_ms', 250, '$.guard_silence_ms', 250)"
    " WHERE robot = 'rover' AND name = 'motors'"
)
"""It may delay any process for a tenth of a second, which would otherwise end a motion."""
SLOWLY_S = 45.0
"""Limits waiting on a busy machine; on an idle one, each wait takes a moment."""
HELD_UP = {"not_armed", "lapsed", "dead_lease", "stale_sensor"}
"""Codes of a motion that ended because a process, or this test, came too late."""
TRIES = 3
pytestmark = pytest.mark.timeout(200)


@pytest.fixture(scope="module")
def rover():
    with running("rover-sim", edits=[PATIENTLY]) as robot:
        until(lambda: phases(robot) == dict.fromkeys(NAMES, "ready"), "all is ready")
        for state in ("odometry", "attitude"):
            until(lambda state=state: (robot.ask(f"{state}/state") or {}).get("valid"), f"its {state}")
        yield robot


@pytest.fixture(autouse=True)
def at_rest(rover):
    yield
    hear(rover, "/obstacle/off")
    hear(rover, "s")
    until(lambda: not moving(rover), "it stands")


def until(look, what, within_s=SLOWLY_S):
    robots.until(look, what, within_s)


def hear(robot, line):
    """Send a line until it is answered: on a busy machine, only a repetition may get an answer."""
    for _ in range(TRIES - 1):
        with suppress(NoAnswerError):
            return robot.say(line)
    return robot.say(line)


def seen(robot, key, message=None):
    """Ask until there is an answer."""
    found = None

    def look():
        nonlocal found
        found = robot.ask(key, message)
        return found is not None

    until(look, f"an answer to {key}")
    return found


def moving(robot):
    return seen(robot, "drive/state")["moving"]


def phases(robot):
    return {one["name"]: one["phase"] for one in seen(robot, "@status")["capabilities"]}


def pose(robot):
    return seen(robot, "world/pose")


def place(robot):
    found = pose(robot)
    return found["x_m"], found["y_m"]


def ended(robot, line):
    """Send a bounded line, repeating it to hold its lease; return how it ended."""
    before = (robot.ask("drive/result") or {}).get("goal")
    goal = lease = None
    word, *numbers = line.strip("/").split("/")
    command = {
        "t": lambda angle: ("turn", {"angle_deg": float(angle)}),
        "go": lambda cm, power: ("command", {"distance_cm": float(cm), "power": float(power)}),
    }[word](*numbers)

    def over():
        nonlocal goal, lease
        result = robot.ask("drive/result")
        if result is not None and result["goal"] == goal != before:
            return True
        reply = robot.ask(f"drive/{command[0]}", {**command[1], **PATIENT, **({"lease": lease} if lease else {})})
        if reply is None:
            return False
        if lease is None:
            assert reply["accepted"], reply
            goal, lease = reply["goal"], reply["lease"]
        return False

    until(over, f"the end of {line}")
    return seen(robot, "drive/result")


def done(robot, line, look):
    """Send a bounded line, again if the machine delayed it; return the last look before its end."""
    for _ in range(TRIES):
        before, result = look(), ended(robot, line)
        if result["code"] not in HELD_UP:
            break
        until(lambda: not moving(robot), "it stands")
    assert result["code"] == "done", result
    return before


def drives(robot, message, enough, what):
    """Move by a twist for as long as it takes."""
    lease = ""

    def over():
        nonlocal lease
        reply = robot.ask("drive/twist", {**message, **PATIENT, "lease": lease})
        lease = reply["lease"] if reply and reply["accepted"] else ""
        return enough()

    until(over, what)


def test_a_word_of_the_console_drives_it(rover):
    began = place(rover)
    until(lambda: hear(rover, "/r/0.3/0")["code"] == 0 and dist(began, place(rover)) > 0.05, "it drives")
    assert hear(rover, "s")["text"] == "stopped"


def test_it_goes_a_distance_by_its_odometry(rover):
    began, before = done(rover, "/go/30/0.3", lambda: (place(rover), seen(rover, "odometry/state")["distance_m"]))
    assert dist(began, place(rover)) == pytest.approx(0.30, abs=0.06)
    until(
        lambda: seen(rover, "odometry/state")["distance_m"] - before == pytest.approx(0.30, abs=0.05), "odometry agrees"
    )


def test_it_turns_by_an_angle_though_its_wheels_slip(rover):
    before = done(rover, "/t/90", lambda: pose(rover)["yaw_rad"])
    turned = (before - pose(rover)["yaw_rad"]) % (2 * pi)
    assert turned == pytest.approx(pi / 2, abs=0.12)


def test_a_twist_takes_it_along_an_arc(rover):
    began = pose(rover)["yaw_rad"]
    turned = lambda: (pose(rover)["yaw_rad"] - began + pi) % (2 * pi) - pi  # noqa: E731 - short
    drives(rover, {"vx_mps": 0.1, "wz_rps": 0.8}, lambda: turned() > 0.4, "it turns left")
    hear(rover, "s")
    reply = seen(rover, "drive/twist", {"vy_mps": 0.2})
    assert (reply["accepted"], reply["code"]) == (False, "bad_value")


def test_it_stands_when_its_sender_is_killed(rover):
    sender = subprocess.Popen([sys.executable, "-c", SENDER, *rover.endpoints])
    try:
        until(lambda: moving(rover) and pose(rover)["speed_mps"] < -0.05, "it drives back")
    finally:
        sender.kill()
        sender.wait()
    until(lambda: not moving(rover), "no motor gets power", 10.0)
    until(lambda: abs(pose(rover)["speed_mps"]) < 0.01, "it stands", 10.0)


def test_it_does_not_start_towards_what_its_lidar_sees_and_may_back_away(rover):
    now = pose(rover)
    ahead = now["x_m"] + 0.6 * cos(now["yaw_rad"]), now["y_m"] + 0.6 * sin(now["yaw_rad"])
    placed = hear(rover, f"/obstacle/{ahead[0]:.3f}/{ahead[1]:.3f}")
    assert placed["code"] == 0, placed
    until(lambda: (seen(rover, "drive/state")["sees"]["lidar forward"] or 9.0) < 0.25, "the lidar sees the box")
    reply = seen(rover, "drive/twist", {"vx_mps": 0.3})
    assert (reply["accepted"], reply["code"]) == (False, "obstacle")
    assert "lidar" in reply["reason"]
    assert seen(rover, "drive/twist", {"vx_mps": -0.1})["accepted"]


def refused(rover, line):
    hear(rover, "s")
    said = hear(rover, line)
    return said["text"] if said["code"] else ""


@pytest.mark.parametrize("fault", ["unplug", "dark"])
def test_without_its_lidar_it_does_not_move(rover, fault):
    assert hear(rover, f"/fault/lidar_port/{fault}")["code"] == 0
    until(lambda: "lidar back" in refused(rover, "/r/0.1/180"), "it is refused")
    assert hear(rover, f"/fault/lidar_port/{fault}/off")["code"] == 0
    until(lambda: not refused(rover, "/r/0.1/180"), "it moves with its lidar")
    hear(rover, "s")
