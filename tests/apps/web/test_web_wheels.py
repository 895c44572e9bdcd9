"""A robot on wheels over HTTP: its state, and stops that reach the motors whatever others hold open."""

import http.client
import json
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from tests.apps.web.test_web_connections import BURDENS, MANY, burdened
from tests.support import programs
from tests.support.robot import Robot, lbr, prepare, running
from tests.support.trace import Trace
from tests.support.waiting import HANG_S, STOPS_S, until

pytestmark = [pytest.mark.slow_start]
RENEW_S = 0.08


class Wheels:
    """The robot, as it is asked over HTTP."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.port = int(robot.web.rpartition(":")[2])

    def ask(self, method: str, path: str, body: Any = None) -> tuple[int, Any]:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=HANG_S)
        try:
            content = None if body is None else json.dumps(body)
            connection.request(method, path, content, {"Content-Type": "application/json"})
            answer = connection.getresponse()
            return answer.status, json.loads(answer.read())
        finally:
            connection.close()

    @property
    def state(self) -> Any:
        return self.ask("GET", "/state")[1]

    def turns(self) -> bool:
        return any(abs(self.state["drive"][side]) > 0.05 for side in ("left", "right"))

    @contextmanager
    def driven(self) -> Iterator[None]:
        """Somebody drives, and goes on asking for it until the end of a `with`."""
        ended = threading.Event()

        def drive() -> None:
            lease, begun = "", False
            while not ended.wait(RENEW_S):
                command = {"power": 0.3, "angle_deg": 90, "lease": lease, "ttl_s": 0.5}
                lease = (self.robot.ask("drive/command", command, source="somebody") or {}).get("lease", "")
                if begun and not lease:
                    return
                begun = begun or bool(lease)

        thread = threading.Thread(target=drive)
        thread.start()
        try:
            until(self.turns, what="wheels that turn")
            yield
        finally:
            ended.set()
            thread.join()


@pytest.fixture(scope="module")
def wheels(tmp_path_factory) -> Iterator[Wheels]:
    home = prepare(tmp_path_factory.mktemp("w") / "h", "battery", "web")
    with running(home) as robot:
        until(lambda: robot.capability("web")["phase"] == "ready")
        yield Wheels(robot)


def test_state_has_what_the_rows_wire_and_nothing_else(wheels):
    state = until(lambda: (found := wheels.state)["drive"] and found["ranges"] and found["battery"] and found)
    assert state["robot"] == "lbr"
    assert state["ranges"]["forward_m"] is not None
    assert state["joints"] is state["motions"] is state["controller"] is None
    assert set(state["age_s"]) == {"drive", "ranges", "battery"}
    document = wheels.ask("GET", "/openapi.json")[1]
    shown = document["paths"]["/state"]["get"]["responses"]["200"]["content"]["application/json"]["schema"]["$ref"]
    described = document["components"]["schemas"][shown.rpartition("/")[2]]["properties"]
    assert set(state) == set(described)
    builtin = {"/state", "/stop", "/estop", "/estop/reset", "/openapi.json", "/qr.svg", "/qr", "/session", "/sessions"}
    faces = {"/index.html", "/stream.mjpg", "/snapshot.jpg", "/cameras", "/call", "/call/{id}"}
    faces |= {"/recordings", "/recordings/{name}"}
    assert {path for path in document["paths"] if not path.startswith("/api")} == builtin | faces


def test_a_stop_stops_the_wheels_whatever_others_hold_open(wheels):
    with wheels.driven(), burdened(wheels.port, BURDENS["half a stop"], MANY):
        answer = wheels.ask("POST", "/stop")
        assert answer == (200, {"message": "stopped"}), f"STOPPED {answer}"
        until(lambda: not wheels.turns(), limit_s=STOPS_S, what="wheels that stand")
        drive = wheels.state["drive"]
        assert (drive["moving"], drive["holder"]) == (False, None)


def test_the_emergency_stop_holds_the_wheels_until_it_is_released(wheels):
    with wheels.driven():
        status, answer = wheels.ask("POST", "/estop", {"reason": "smoke"})
        assert (status, answer["engaged"], answer["noticed"]) == (200, True, True)
        until(lambda: not wheels.turns(), limit_s=STOPS_S, what="wheels that stand")
    assert wheels.state["drive"]["estop"]
    assert not wheels.robot.ask("drive/command", {"power": 0.3})["accepted"]
    until(lambda: wheels.ask("POST", "/estop/reset")[0] == 200, what="a release")
    until(lambda: not wheels.state["drive"]["estop"])
    assert not wheels.turns()


def test_the_robot_says_what_it_is_and_each_of_its_streams_and_words_answers(wheels):
    told = until(lambda: (found := wheels.ask("GET", "/api"))[0] == 200 and found[1])
    assert (told["robot"], told["simulated"], told["role"]) == ("lbr", True, "admin")
    assert {"motors", "ranges", "drive", "web"} <= {one["name"] for one in told["capabilities"]}
    assert {row["name"] for row in told["ranges"]} == {"forward", "back", "left", "right", "bottom"}
    document = wheels.ask("GET", "/openapi.json")[1]
    for stream in ("drive/state", "ranges/readings", "battery/state", "web/state"):
        assert f"/api/{stream}" in document["paths"]
        newest = until(lambda stream=stream: (got := wheels.ask("GET", f"/api/{stream}"))[0] == 200 and got[1])
        assert newest["age_s"] < 5.0
    assert wheels.ask("GET", "/api/drive/command")[0] == 404
    said = wheels.ask("POST", "/api/console", {"line": "/report/robot"})[1]
    assert said["data"]["robot"] == "lbr"
    assert wheels.ask("POST", "/api/console", {"line": "nonsense"})[1]["reason_code"] == "unknown_command"
    assert wheels.ask("POST", "/api/drive/command", {"power": 7})[0] == 400
    assert wheels.ask("POST", "/api/drive/command", {"power": "fast"})[0] == 400


PAGE = """
import json, sys
from websockets.sync.client import connect

with connect(f"ws://127.0.0.1:{sys.argv[1]}/api/live") as socket:
    socket.send(json.dumps({"hear": ["drive/state"]}))
    socket.send(json.dumps({"hold": {"to": "drive/command", "message": {"power": 0.3, "angle_deg": 90}, "n": 1}}))
    silent = False
    while True:
        told = json.loads(socket.recv())
        if not told.get("hold", {}).get("holds", True):
            print(json.dumps(told), flush=True)
        moving = told.get("streams", {}).get("drive/state", {}).get("message", {}).get("moving")
        silent = silent or (sys.argv[2] == "silent" and bool(moving))
        if not silent:
            socket.send(json.dumps({"keep": 1, "t": told["t"]}))
"""


def page(wheels, how=""):
    return programs.start([sys.executable, "-c", PAGE, str(wheels.port), how], stdout=subprocess.PIPE)


def halves(trace):
    return trace.now().most > 0.1


@pytest.mark.parametrize("how", ["killed", "frozen", "silent"])
def test_wheels_stand_after_their_page_is_gone(wheels, how):
    trace = Trace(wheels.robot.trace)
    client = page(wheels, how)
    try:
        until(lambda: halves(trace), what="wheels that turn")
        holder = wheels.state["drive"]["holder"]
        at_ns = time.monotonic_ns()
        if how != "silent":
            client.send_signal(signal.SIGKILL if how == "killed" else signal.SIGSTOP)
        stood = trace.first_zero(at_ns, limit_s=STOPS_S)
    finally:
        client.kill()
        client.communicate()
    assert holder in {"web:127.0.0.1", None}  # a silent one may be over by now
    assert stood is not None
    until(lambda: wheels.state["drive"]["holder"] is None)


def test_a_stop_ends_what_a_page_holds_and_its_stick_begins_nothing_again(wheels):
    trace = Trace(wheels.robot.trace)
    client = page(wheels)
    try:
        until(lambda: halves(trace), what="wheels that turn")
        assert wheels.ask("POST", "/stop")[0] == 200
        told = json.loads(client.stdout.readline())["hold"]
        assert told["code"] == "stopped"
        assert trace.first_zero(time.monotonic_ns(), limit_s=0.5) or trace.now().zero
        assert not wheels.state["drive"]["moving"]
    finally:
        client.kill()
        client.communicate()


def test_who_moved_it_from_a_page_is_in_the_audit_trail(wheels):
    wheels.ask("POST", "/api/console", {"line": "/r/0.2/90"})
    found = lbr(wheels.robot.home, "db", "audit")
    assert "web:127.0.0.1" in found.stdout


def test_a_stop_that_nothing_answers_is_told(wheels):
    wheels.robot.edit("UPDATE channel SET enabled = 0 WHERE robot = 'lbr' AND source = 'web.halt'")

    def refused() -> bool:
        try:
            status, answer = wheels.ask("POST", "/stop")
        except OSError:
            return False  # it restarts with its new wiring
        return status == 503 and "by channel rows" in answer["message"]

    until(refused)
