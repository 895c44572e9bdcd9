"""What becomes of a move when the server that wanted it dies, and of the server's clients."""

import http.client
import json
import math
import os
import signal
import time

import pytest
from websockets.sync.client import connect

from tests.apps.web.web_stage import ending
from tests.support.robot import only, prepare, running
from tests.support.waiting import HANG_S, until

pytestmark = [pytest.mark.slow_start]
EDITS = (
    only("uxa90", "servos", "joints", "web", "world"),
    "UPDATE joint SET speed_rps = 0.25 WHERE robot = 'uxa90' AND name = 'neck_yaw'",
    "UPDATE capability SET settings = json_set(settings, '$.settle_s', 0.05) WHERE robot = 'uxa90' AND name = 'servos'",
)
AGAIN_S = 0.5


def ask(base: str, method: str, path: str) -> tuple[int, bytes]:
    connection = http.client.HTTPConnection(base.removeprefix("http://"), timeout=HANG_S)
    try:
        connection.request(method, path)
        answer = connection.getresponse()
        return answer.status, answer.read()
    finally:
        connection.close()


def test_a_server_that_is_killed_in_the_middle_of_a_move_leaves_the_joint_where_it_is(tmp_path):
    with running(prepare(tmp_path / "home", edits=EDITS), profile="uxa90-sim") as robot:
        until(lambda: robot.capability("web")["phase"] == "ready")

        def state() -> dict:
            return until(lambda: robot.ask("joints/state"), what="joints/state")

        def goal() -> float:
            return state()["joints"]["neck_yaw"]["goal_rad"] or 0.0

        def holds() -> bool:
            return not (now := state())["moving"] and now["holder"] is None

        asked_at = -math.inf

        def turns() -> bool:
            """On a busy machine a lease may lapse at once; then the move is asked for again, not more often than is allowed."""
            nonlocal asked_at
            if not state()["moving"] and time.monotonic() - asked_at > AGAIN_S:
                asked_at = time.monotonic()
                ask(robot.web, "GET", "/motor?id=23&pos=220")
            return abs(goal()) > 0.02

        pid = robot.capability("web")["pid"]
        with connect(robot.web.replace("http", "ws") + "/ws") as states:
            states.recv(timeout=HANG_S)
            until(turns, what="a neck that turns")
            os.kill(pid, signal.SIGKILL)
            until(holds, what="a neck that holds, and nobody moves")
            ending(states)
        held = goal()
        assert abs(held) < 1.5, "it went all the way"
        until(lambda: (web := robot.capability("web"))["restarts"] and web["phase"] == "ready")
        assert until(lambda: ask(robot.web, "GET", "/")) == (200, b"OK")
        assert goal() == pytest.approx(held, abs=0.02), "it went on by itself"
        said = json.loads(until(lambda: b'"noticed":true' in (told := ask(robot.web, "POST", "/estop")[1]) and told))
        assert said["message"].startswith("emergency stop: ")
        until(lambda: not robot.ask("@estop")["waiting"], what="it is acknowledged")
        assert robot.line("estop")["text"] == robot.status()["estop"]["text"]
        assert ask(robot.web, "GET", "/motor?id=23&pos=100")[0] == 409
        assert until(lambda: ask(robot.web, "POST", "/estop/reset")[0] == 200)
        assert robot.status()["estop"]["engaged"] is False
        assert f" reaches {robot.web}/" in robot.line("qr")["text"]
