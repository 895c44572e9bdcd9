"""lbr's old API with a robot that runs: its telemetry, motions by it, and a client that is killed while it drives."""

import http.client
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from tests.docs.ready import measured
from tests.support import programs
from tests.support.robot import Robot, prepare, running
from tests.support.trace import Trace
from tests.support.waiting import HANG_S, STOPS_S, until

pytestmark = [pytest.mark.slow_start]
PARTS = ("imu", "attitude", "odometry", "battery", "telemetry", "speech", "dock", "cameras", "camera_front", "web_api")
HEARTBEAT_S = 1.5
ALL = {"Ranges", "Timestamp", "MPU", "amperages", "Bat", "Count", "dockSignal", "cameras"}
SLACK_S = 0.8
"""The lease's end, the ramp, and what a busy machine takes."""
STOP = {"level": 0, "angle": 0}
CLIENT = """
import http.client, json, sys, time

def ask(method, path, body=None):
    connection = http.client.HTTPConnection("127.0.0.1", int(sys.argv[1]), timeout=5)
    text = None if body is None else json.dumps(body) + "\\r\\n"
    connection.request(method, path, text, {"Content-type": "application/json", "User-Agent": "fsm"})
    return connection.getresponse().read()

print("drives", flush=True)
while True:
    ask("POST", "/", {"level": 0.4, "angle": 90})  # again and again: on a busy machine it may be refused, or lapse
    for _ in range(3):
        ask("GET", "/telemetry")
        time.sleep(0.3)
"""


class Api:
    """The robot, as its old clients ask it."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.port = int(robot.served("web_api").rpartition(":")[2])
        self.trace = Trace(robot.trace)

    def ask(self, method: str, path: str, body: Any = None) -> tuple[int, Any]:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=HANG_S)
        try:
            text = None if body is None else json.dumps(body) + "\r\n"
            connection.request(method, path, text, {"Content-type": "application/json", "User-Agent": "test"})
            answer = connection.getresponse()
            content = answer.read()
            return answer.status, json.loads(content) if content.startswith(b"{") else content
        finally:
            connection.close()

    @property
    def telemetry(self) -> Any:
        return self.ask("GET", "/telemetry")[1]

    def knows_all(self) -> bool:
        """Say whether every part is there, and the compass has told where it looks."""
        found = self.telemetry
        return set(found) >= ALL and None not in found["MPU"].values() and found["cameras"]["front"]["status"] == "on"

    def stands(self) -> bool:
        """As state machines see it: both currents are exactly 0."""
        amps = self.telemetry["amperages"]
        return amps["leftMotor"] == 0.0 and amps["rightMotor"] == 0.0

    @property
    def goal(self) -> str:
        """What the drive is up to; a busy machine may not answer."""
        return (self.robot.ask("drive/state") or {"goal": "unknown"})["goal"] or ""

    def turns(self) -> bool:
        return self.trace.now().least > 0.05

    def accepted(self, body: Any) -> bool:
        """On a busy machine a motion may be refused for a late reading; then it is asked for again."""
        return self.ask("POST", "/", body)[0] == 200

    @contextmanager
    def client(self) -> Iterator["subprocess.Popen[str]"]:
        """A client that drives and polls."""
        popen = programs.start([sys.executable, "-c", CLIENT, str(self.port)], stdout=subprocess.PIPE, text=True)
        try:
            assert popen.stdout.readline() == "drives\n"
            yield popen
        finally:
            popen.kill()
            popen.wait()
            popen.stdout.close()


@pytest.fixture(scope="module")
def api(tmp_path_factory) -> Iterator[Api]:
    home = prepare(tmp_path_factory.mktemp("o") / "h", *PARTS)
    with running(home) as robot:
        until(lambda: robot.capability("web_api")["phase"] == "ready")
        measured(robot)
        found = Api(robot)
        until(found.knows_all, what="every part of the telemetry")
        yield found


@pytest.fixture(autouse=True)
def at_rest(api) -> Iterator[None]:
    yield
    api.ask("POST", "/", STOP)
    until(lambda: api.trace.now().zero, what="wheels that stand")


def test_a_turn_is_made_for_a_client_that_polls_as_the_state_machine_does(api):
    def turned() -> bool:
        """On a busy machine the inertial unit may be late, which ends a turn; then it is asked for again."""
        if not api.accepted({"turn": 60}):
            return False
        until(api.turns, what="a turn that has begun")
        assert api.trace.now().left >= 0.0 >= api.trace.now().right, "clockwise"
        until(lambda: api.telemetry and not api.goal, what="the end of the turn")
        return bool(until(lambda: api.robot.ask("drive/result"))["result"] == "reached")

    until(turned, what="a turn that reached its end")
    until(api.stands, what="currents of 0")


def test_a_client_that_is_killed_while_it_drives_leaves_wheels_that_stand(api):
    with api.client() as client:
        until(api.turns, what="wheels that turn")
        still = time.monotonic() + HEARTBEAT_S + 0.5
        until(lambda: time.monotonic() > still or not api.turns())
        assert api.turns(), "its polls keep it going"
        killed_ns = time.monotonic_ns()
        client.send_signal(signal.SIGKILL)
        zero = api.trace.first_zero(killed_ns, HEARTBEAT_S + 3.0)
    assert zero is not None, "the wheels turn on"
    took_s = (zero.at_ns - killed_ns) * 1e-9
    print(f"wheels zero {took_s:.2f} s after the client was killed")
    assert took_s <= HEARTBEAT_S + SLACK_S
    until(lambda: any("was silent for" in one["text"] for one in api.robot.events()), what="an event that says so")


def test_it_speaks_hears_the_dock_and_switches_cameras(api):
    until(lambda: api.ask("POST", "/say", {"speech": "a text / with a slash"}) == (200, b""))

    def heard() -> bool:
        """A beam counts for a while, in which a busy machine may not tell of it."""
        told = api.ask("POST", "/docksignal", {"dockSignal": {"time": time.time(), "left": 1}})
        return told == (204, b"") and api.telemetry.get("dockSignal", {}).get("left") == 1

    until(heard, what="the dock's left beam")
    until(lambda: api.ask("POST", "/camera/off", {}) == (200, {}))
    until(lambda: api.ask("GET", "/cameras")[1]["front"]["status"] == "off")
    until(lambda: api.ask("POST", "/camera/front", {}) == (200, {}))
    until(lambda: api.ask("GET", "/cameras")[1]["front"]["status"] == "on")


def test_the_server_that_is_killed_while_it_moves_the_base_leaves_it_standing(api):
    pid = api.robot.capability("web_api")["pid"]
    until(lambda: api.turns() or (api.accepted({"level": 0.3, "angle": 90}) and api.turns()), what="wheels that turn")
    killed_ns = time.monotonic_ns()
    os.kill(pid, signal.SIGKILL)
    assert api.trace.first_zero(killed_ns, STOPS_S) is not None

    def is_back() -> bool:
        unit = api.robot.capability("web_api")
        return unit["pid"] not in {pid, None} and unit["phase"] == "ready"

    until(is_back)
    assert api.trace.now().zero, "it went on by itself"
