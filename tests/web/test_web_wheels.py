"""A robot on wheels over HTTP: its state, and stops that reach the motors whatever others hold open."""

import http.client
import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from tests.support.robot import Robot, prepare, running, until
from tests.web.test_web_connections import MANY, burdened

pytestmark = [pytest.mark.slow_start, pytest.mark.timeout(30)]
SERVED = "UPDATE capability SET enabled = 1 WHERE robot = 'lbr' AND name = 'web'"
RENEW_S = 0.08


class Wheels:
    """The robot, as it is asked over HTTP."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.port = int(robot.web.rpartition(":")[2])

    def ask(self, method: str, path: str, body: Any = None) -> tuple[int, Any]:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=5)
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
            lease = ""
            while not ended.wait(RENEW_S):
                command = {"power": 0.3, "angle_deg": 90, "lease": lease, "ttl_s": 0.5}
                lease = (self.robot.ask("drive/command", command, source="somebody") or {}).get("lease", "")
                if not lease:
                    return

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
    home = prepare(tmp_path_factory.mktemp("w") / "h", "battery", edits=(SERVED,))
    with running(home) as robot:
        until(lambda: robot.capability("web")["phase"] == "ready", limit_s=10.0)
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
    builtin = {
        "/state",
        "/stop",
        "/estop",
        "/estop/reset",
        "/openapi.json",
        "/qr.svg",
        "/qr",
        "/session",
        "/sessions",
        "/api/pair",
    }
    assert set(document["paths"]) == builtin | {"/index.html", "/stream.mjpg", "/snapshot.jpg", "/cameras"}


@pytest.mark.parametrize(
    "held", [b"", b"POST /stop HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n\r\n{"], ids=["idle", "half a stop"]
)
def test_a_stop_stops_the_wheels_whatever_others_hold_open(wheels, held):
    with wheels.driven(), burdened(wheels.port, held, MANY):
        answer = wheels.ask("POST", "/stop")
        assert answer == (200, {"message": "stopped"}), f"STOPPED {answer}"
        until(lambda: not wheels.turns(), limit_s=1.0, what="wheels that stand")
        drive = wheels.state["drive"]
        assert (drive["moving"], drive["holder"]) == (False, None)


def test_the_emergency_stop_holds_the_wheels_until_it_is_released(wheels):
    with wheels.driven(), burdened(wheels.port, b"", MANY):
        status, answer = wheels.ask("POST", "/estop", {"reason": "smoke"})
        assert (status, answer["engaged"], answer["noticed"]) == (200, True, True)
        until(lambda: not wheels.turns(), limit_s=1.0, what="wheels that stand")
    assert wheels.state["drive"]["estop"]
    assert not wheels.robot.ask("drive/command", {"power": 0.3})["accepted"]
    until(lambda: wheels.ask("POST", "/estop/reset")[0] == 200, what="a release")
    until(lambda: not wheels.state["drive"]["estop"])
    assert not wheels.turns()


def test_a_stop_that_nothing_answers_is_told(wheels):
    wheels.robot.edit("UPDATE channel SET enabled = 0 WHERE robot = 'lbr' AND source = 'web.halt'")

    def refused() -> bool:
        try:
            status, answer = wheels.ask("POST", "/stop")
        except OSError:
            return False  # it restarts with its new wiring
        return status == 503 and "wired to this server by channel rows" in answer["message"]

    until(refused, limit_s=10.0)
