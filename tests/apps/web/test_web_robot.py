"""A robot on wheels over HTTP: its state, stops that reach the motors whatever others hold open, and its rows: looked at,
tried, changed, and refused beside the field that is wrong."""

import http.client
import json
import select
import signal
import sqlite3
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from typing import Any

import httpx
import pytest

from lbr.testing.device import plugged
from tests.apps.web.test_web_connections import BURDENS, MANY, burdened
from tests.support import programs
from tests.support.commands import here
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

    def stand(self) -> bool:
        """Whether the wheels stand, and nobody drives: a rule may stop a motion for a moment while its lease lives."""
        drive = self.state["drive"]
        return (drive["moving"], drive["holder"]) == (False, None)

    @contextmanager
    def driven(self) -> Iterator[None]:
        """Somebody drives, and goes on asking for it until the end of a `with`; once wheels turn nothing begins anew."""
        ended, turned, asks = threading.Event(), threading.Event(), threading.Lock()

        def drive() -> None:
            lease = ""
            while not ended.wait(RENEW_S):
                with asks:
                    if turned.is_set() and not lease:
                        return
                    command = {"power": 0.3, "angle_deg": 90, "lease": lease, "ttl_s": 0.5}
                    lease = (self.robot.ask("drive/command", command, source="somebody") or {}).get("lease", "")

        thread = threading.Thread(target=drive)
        thread.start()
        try:
            until(self.turns, what="wheels that turn")
            with asks:
                turned.set()
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


@pytest.fixture(scope="module")
def robot(wheels) -> Robot:
    return wheels.robot


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
        until(wheels.stand, limit_s=STOPS_S, what="wheels that stand")


def test_the_emergency_stop_holds_the_wheels_until_it_is_released(wheels):
    with wheels.driven():
        status, answer = wheels.ask("POST", "/estop", {"reason": "smoke"})
        assert (status, answer["engaged"]) == (200, True)
        until(wheels.stand, limit_s=STOPS_S, what="wheels that stand")
    until(lambda: wheels.ask("POST", "/estop", {"reason": "smoke"})[1]["noticed"], what="the base's word of it")
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
import json, sys, time
from websockets.sync.client import connect

HOLD = {"to": "drive/command", "message": {"power": 0.3, "angle_deg": 90}}
with connect(f"ws://127.0.0.1:{sys.argv[1]}/api/live") as socket:
    socket.send(json.dumps({"hear": ["drive/state"]}))
    silent, n = False, 1
    socket.send(json.dumps({"hold": HOLD | {"n": n}}))
    while True:
        told = json.loads(socket.recv())
        if not told.get("hold", {}).get("holds", True):
            print(json.dumps(told), flush=True)
            if sys.argv[2] and not silent:  # a busy machine held it up
                time.sleep(0.1)
                n += 1
                socket.send(json.dumps({"release": True}))
                socket.send(json.dumps({"hold": HOLD | {"n": n}}))
        moving = told.get("streams", {}).get("drive/state", {}).get("message", {}).get("moving")
        silent = silent or (sys.argv[2] == "silent" and bool(moving))
        if not silent:
            socket.send(json.dumps({"keep": n, "t": told["t"]}))
"""


@contextmanager
def page(wheels, how=""):
    """A page that drives in a process of its own; unless `how` is empty, it begins again what a busy machine ended."""
    client = programs.start([sys.executable, "-c", PAGE, str(wheels.port), how], stdout=subprocess.PIPE)
    try:
        yield client
    finally:
        client.kill()
        client.communicate()


def halves(trace):
    return trace.now().most > 0.1


@pytest.mark.parametrize("how", ["killed", "frozen", "silent"])
def test_wheels_stand_after_their_page_is_gone(wheels, how):
    trace = Trace(wheels.robot.trace)
    with page(wheels, how) as client:
        until(lambda: halves(trace), what="wheels that turn")
        holder = wheels.state["drive"]["holder"]
        if how != "silent":
            client.send_signal(signal.SIGKILL if how == "killed" else signal.SIGSTOP)
        until(lambda: trace.now().zero, limit_s=STOPS_S, what="wheels that stand")
    assert holder in {"web:127.0.0.1", None}  # a silent one may be over by now
    until(lambda: wheels.state["drive"]["holder"] is None)


def test_a_stop_ends_what_a_page_holds_and_its_stick_begins_nothing_again(wheels):
    trace = Trace(wheels.robot.trace)

    def end() -> str:
        """Stop what a page holds, and return by what it was told to have ended: its lease may have lapsed before."""
        with page(wheels) as client:
            told = lambda: select.select([client.stdout], [], [], 0)[0]  # noqa: E731
            until(lambda: halves(trace) or told(), what="wheels that turn")
            assert wheels.ask("POST", "/stop")[0] == 200
            until(wheels.stand, limit_s=STOPS_S, what="wheels that stand")
            code = json.loads(client.stdout.readline())["hold"]["code"]
            assert wheels.stand()
            return code

    until(lambda: end() == "stopped", what="a motion that ends by a stop")


def test_who_moved_it_from_a_page_is_in_the_audit_trail(wheels):
    wheels.ask("POST", "/api/console", {"line": "/r/0.2/90"})
    until(lambda: "web:127.0.0.1" in here(wheels.robot.home, "db", "audit").stdout, what="the line in the trail")


@pytest.fixture(scope="module")
def owner(robot):
    """A browser of the robot's owner, on its machine."""
    with httpx.Client(base_url=robot.web, timeout=8.0) as client:
        until(lambda: client.get("/api").status_code == 200)
        yield client


def rows(owner: httpx.Client, table: str) -> dict:
    answer = owner.get(f"/api/rows/{table}")
    assert answer.status_code == 200, answer.text
    return answer.json()["data"]


def row(owner: httpx.Client, table: str, **key: object) -> dict:
    return next(one for one in rows(owner, table)["rows"] if key.items() <= one.items())


def change(
    owner: httpx.Client, table: str, before: dict | None, after: dict | None, *, write: bool = True
) -> httpx.Response:
    return owner.post(
        "/api/rows", json={"changes": [{"table": table, "before": before, "after": after}], "write": write}
    )


def role(owner: httpx.Client, headers: dict[str, str]) -> str | None:
    """Return what a token lets in as; None where it does not, or while the server opens again with other tokens."""
    with suppress(httpx.TransportError):
        return owner.get("/api", headers=headers).json().get("role")
    return None


def settings(robot: Robot, name: str) -> str:
    with closing(sqlite3.connect(robot.home / "robot.db")) as database:
        query = "SELECT settings FROM capability WHERE robot = 'lbr' AND name = ?"
        return database.execute(query, (name,)).fetchone()[0]


def test_tables_are_told_with_the_schema_of_what_they_hold(owner):
    tables = {one["table"]: one for one in owner.get("/api/rows").json()["data"]["tables"]}
    assert {"robot", "capability", "channel", "device", "verb", "phrase", "range_sensor"} <= tables.keys()
    assert tables["capability"]["rows"] > 10
    assert "program" in tables["external_command"]["fixed"]
    assert "user_token" not in tables
    found = rows(owner, "capability")
    assert found["key"] == ["name"]
    assert "max_speed_mps" in str(found["settings"]["drive"])
    assert isinstance(row(owner, "capability", name="drive")["settings"], dict)
    assert owner.get("/api/rows/nonsense").status_code == 404


def test_a_change_is_tried_before_it_is_written_and_says_what_restarts(owner, robot):
    before = row(owner, "capability", name="drive")
    after = {"settings": before["settings"] | {"max_power": 0.5}}
    tried = change(owner, "capability", before, after, write=False).json()
    assert tried["accepted"]
    assert tried["touched"] == {"start": [], "stop": [], "restart": ["drive"], "plug": []}
    assert "0.5" not in settings(robot, "drive")


def test_what_is_wrong_stands_beside_its_field_and_nothing_is_written(owner, robot):
    before, kept = row(owner, "capability", name="drive"), settings(robot, "drive")
    answer = change(owner, "capability", before, {"settings": before["settings"] | {"max_power": 7}})
    assert answer.status_code == 400
    (problem,) = answer.json()["problems"]
    assert (problem["table"], problem["row"], problem["column"]) == ("capability", "drive", "settings"), problem
    assert "max_power" in problem["text"]
    assert settings(robot, "drive") == kept


OPEN = {"host": "0.0.0.0", "clear_text": True, "trusted": ["0.0.0.0/0"], "legacy": "on"}


@pytest.mark.parametrize("name", [*OPEN, "cors"])
def test_a_page_decides_of_no_setting_who_comes_in(owner, robot, name):
    """A server for people that was taken over has their rights, and lets no others in."""
    before, kept = row(owner, "capability", name="web"), settings(robot, "web")
    answer = change(owner, "capability", before, {"settings": before["settings"] | {name: OPEN.get(name, ["*"])}})
    assert answer.status_code == 400
    (problem,) = answer.json()["problems"]
    assert problem["column"] == "settings"
    assert f"{name} decides who comes in" in problem["text"]
    assert settings(robot, "web") == kept


@pytest.mark.parametrize(
    "new",
    [
        {"kind": "web", "settings": {"port": 0} | OPEN},
        {"kind": "lan", "settings": {"listen": ["tcp/127.0.0.1:7449"]}},
        {"kind": "mqtt", "settings": {"host": "broker.example", "token": "phone", "words": {"go": {"do": "go"}}}},
    ],
)
def test_a_page_makes_no_other_door(owner, new):
    answer = change(owner, "capability", None, {"name": "door"} | new)
    assert answer.status_code == 400
    assert "decides who comes in" in answer.text


def test_a_page_opens_no_door_that_is_shut_and_changes_what_else_a_server_has(owner):
    shut = row(owner, "capability", name="lan")
    assert "decides who comes in" in change(owner, "capability", shut, {"enabled": True}).text
    web = row(owner, "capability", name="web")
    other = {"settings": web["settings"] | {"requests_per_s": 150.0}}
    assert change(owner, "capability", web, other, write=False).json()["accepted"]


def test_a_row_that_was_changed_meanwhile_is_not_written_over(owner, robot):
    before = row(owner, "phrase", name="hello", language="en")
    robot.edit("UPDATE phrase SET text = 'Hello there.' WHERE name = 'hello' AND language = 'en'")
    answer = change(owner, "phrase", before, {"text": "Hi."})
    assert (answer.status_code, answer.json()["code"]) == (409, "changed")
    told = answer.json()
    assert (told["changed_by"], told["changed_at"][:2]) == ("", "20"), "an edit of the database has a time and no name"
    now = row(owner, "phrase", name="hello", language="en")
    assert now["text"] == "Hello there."
    assert change(owner, "phrase", now, {"text": "Hi."}).status_code == 200
    assert row(owner, "phrase", name="hello", language="en")["text"] == "Hi."


def test_who_was_first_is_named_to_the_second_of_two_pages(owner):
    both = row(owner, "phrase", name="goodbye", language="en")
    assert change(owner, "phrase", both, {"text": "Until soon."}).status_code == 200
    late = change(owner, "phrase", both, {"text": "Farewell."}).json()
    assert (late["accepted"], late["code"]) == (False, "changed")
    assert late["changed_by"].startswith("web:")
    assert late["changed_by"] in late["reason"]
    assert late["changed_at"]


def test_what_happened_is_told_of_one_part_and_from_a_level_on(owner, robot):
    def told(**wanted: object) -> list[dict]:
        answer = owner.get("/api/events", params=wanted)
        assert answer.status_code == 200, answer.text
        return answer.json()["data"]["events"]

    until(lambda: any(one["kind"] == "started" for one in told(subject="drive")))
    assert {one["subject"] for one in told(subject="drive")} == {"drive"}
    assert 0 < len(told(limit=20)) <= 20
    assert all(one["level"] != "info" for one in told(level="warning"))
    assert told(subject="nothing") == []
    for wrong in ({"level": "loud"}, {"limit": 0}, {"limit": 10_000}):
        assert owner.get("/api/events", params=wrong).status_code == 400


def test_a_row_is_added_and_deleted_and_who_did_it_is_told(owner, robot):
    new = {"name": "for_a_test", "language": "en", "text": "A test."}
    assert change(owner, "phrase", None, new).status_code == 200
    assert change(owner, "phrase", None, new).json()["code"] == "exists"
    assert change(owner, "phrase", row(owner, "phrase", name="for_a_test"), None).status_code == 200
    assert all(one["name"] != "for_a_test" for one in rows(owner, "phrase")["rows"])

    def told():
        edits = [one["text"] for one in robot.events() if one["kind"] == "edit"]
        return any(text.startswith("web:") and "phrase 'for_a_test' (deleted)" in text for text in edits)

    until(told, what="the event of it")


def test_an_edit_is_in_force_soon_and_stops_are_heard_meanwhile(owner, robot):
    before = row(owner, "capability", name="drive")
    assert change(owner, "capability", before, {"help": "The base, as a test calls it"}).status_code == 200
    speed = before["settings"] | {"max_power": 0.6}
    assert change(owner, "capability", before | {"help": "The base, as a test calls it"}, {"settings": speed}).json()[
        "touched"
    ]["restart"] == ["drive"]
    assert owner.post("/stop").status_code == 200
    until(lambda: robot.capability("drive")["phase"] == "ready")


@pytest.mark.parametrize(
    ("table", "key", "after", "code"),
    [
        ("external_command", {}, {"name": "evil", "argv": ["/bin/sh"]}, "denied"),
        ("capability", {}, {"name": "evil", "kind": "exec", "settings": {"argv": ["/bin/sh"]}}, "denied"),
        ("capability", {"name": "drive"}, {"kind": "exec"}, "denied"),
        ("robot", {"name": "lbr"}, {"estop_engaged": False, "estop_reason": "x"}, "read_only"),
        ("robot", {}, {"name": "second"}, "denied"),
        ("phrase", {}, {"language": "en"}, "bad_value"),
        ("phrase", {}, {"name": "a", "language": "en", "nonsense": 1}, "unknown_name"),
        ("user_token", {}, {"name": "a"}, "unknown_name"),
    ],
)  # fmt: skip
def test_what_a_page_may_not_change_is_refused_with_its_code(owner, table, key, after, code):
    before = row(owner, table, **key) if key else None
    answer = change(owner, table, before, after, write=False)
    assert answer.json()["code"] == code, answer.text
    assert answer.status_code in {400, 404, 409}


@pytest.mark.parametrize("body", [{}, {"changes": []}, {"changes": [{"table": "phrase"}]}, {"changes": [{"table": 1}]}, {"changes": [{"table": "phrase", "after": {"name": float("1e308")}}]}])  # fmt: skip
def test_rubbish_is_refused(owner, body):
    assert owner.post("/api/rows", json=body).status_code == 400


def test_a_token_is_listed_without_what_proves_it_and_locked_out_at_once(owner, robot):
    made = here(robot.home, "token", "add", "visitor", "--role", "view", "--for", "web")
    token = made.stdout.split()[0]
    viewer = {"Authorization": f"Bearer {token}"}
    until(lambda: role(owner, viewer) == "view")
    (listed,) = [one for one in owner.get("/api/tokens").json()["data"]["tokens"] if one["name"] == "visitor"]
    assert (listed["role"], listed["good_for"], listed["revoked_at"]) == ("view", "web", None)
    assert "hash" not in listed
    for path in ("/api/tokens", "/api/rows", "/api/logs/drive"):
        assert owner.get(path, headers=viewer).status_code == 403
    called = {"name": "visitor", "called": "Ann"}
    assert owner.post("/api/tokens/rename", json=called, headers=viewer).status_code == 403
    assert owner.post("/api/devices", headers=viewer).status_code == 403
    assert (
        owner.post("/api/rows", json={"changes": [{"table": "phrase", "after": {}}]}, headers=viewer).status_code == 403
    )
    assert owner.post("/api/tokens/revoke", json={"name": "visitor"}).status_code == 200
    until(lambda: role(owner, viewer) is None and role(owner, {}) == "admin")
    assert role(owner, viewer) is None
    assert owner.post("/api/tokens/revoke", json={"name": "visitor"}).status_code == 404


def test_a_token_gets_a_name_for_people_and_goes_on(owner, robot):
    token = here(robot.home, "token", "add", "tablet", "--role", "view", "--for", "web").stdout.split()[0]
    holder = {"Authorization": f"Bearer {token}"}
    until(lambda: role(owner, holder) == "view")
    assert owner.post("/api/tokens/rename", json={"name": "tablet", "called": "Ann"}).status_code == 200
    (listed,) = [one for one in owner.get("/api/tokens").json()["data"]["tokens"] if one["name"] == "tablet"]
    assert listed["called"] == "Ann"
    until(lambda: any("'Ann'" in one["text"] for one in robot.events()), what="the event of it")
    assert role(owner, holder) == "view"
    for bad, status in (({"name": "none", "called": "Ann"}, 404), ({"name": "tablet", "called": ""}, 400)):
        assert owner.post("/api/tokens/rename", json=bad).status_code == status


def test_what_is_plugged_in_is_told_and_its_rows_are_previewed_as_any_change(owner, robot, tmp_path):
    before = rows(owner, "device")
    answer = owner.post("/api/devices", timeout=12.0)
    assert answer.status_code == 200, answer.text
    assert {"robot", "devices", "proposals", "hints"} <= answer.json()["data"].keys()
    assert answer.json()["data"]["robot"] == "lbr"
    with plugged("ld06", tmp_path, name="lidar") as found:
        said = lbr(robot.home, "devices", "--json", "--robot", "lbr", "--port", found.device.address)
        (offer,) = json.loads(said.stdout)["proposals"]
    assert offer["problems"] == []
    tried = owner.post("/api/rows", json={"changes": offer["changes"], "write": False})
    assert tried.status_code == 200, tried.text
    assert "ld06" in tried.json()["touched"]["start"]
    assert rows(owner, "device") == before


def test_the_end_of_a_log_is_told_and_no_other_file(owner, robot):
    log = robot.home / "logs" / "lbr-base.log"
    assert " drive " in owner.get("/api/logs/drive").json()["data"]["text"], "its events are in it"
    assert " drive " in here(robot.home, "logs", "drive").stdout
    log.write_bytes(b"x" * 70_000 + b"\nthe last line\n")
    found = owner.get("/api/logs/drive").json()["data"]
    assert "the last line\n" in found["text"], "and what the robot has written since"
    assert len(found["text"]) <= 64_000
    log.write_bytes(b"the first line\n" + b"x" * 60_000)
    assert owner.get("/api/logs/drive").json()["data"]["text"].startswith("the first line\n"), "nothing was left out"
    for name in ("nonsense", "..%2Frobot.db", "%2Fetc%2Fpasswd"):
        assert owner.get(f"/api/logs/{name}").status_code == 404


def undo(owner: httpx.Client, revision: int) -> httpx.Response:
    return owner.post("/api/rows/undo", json={"revision": revision})


def test_a_change_is_taken_back_by_its_revision_but_not_what_others_changed_since(owner):
    name = {"name": "lbr"}
    owner_was, text_was = (row(owner, "robot", **name)[one] for one in ("owner", "description"))
    first = change(owner, "robot", name, {"owner": "Ann"}).json()
    second = change(owner, "robot", name, {"description": "by Ann"}).json()
    assert undo(owner, first["revision"]).json()["accepted"]
    kept = row(owner, "robot", **name)
    assert (kept["owner"], kept["description"]) == (owner_was, "by Ann")
    change(owner, "robot", name, {"description": "by Bob"})
    refused = undo(owner, second["revision"])
    assert (refused.status_code, refused.json()["code"]) == (409, "changed")
    assert row(owner, "robot", **name)["description"] == "by Bob"
    change(owner, "robot", name, {"description": text_was})
    assert undo(owner, 1).status_code == 404, "rows that the page did not write"


def test_a_stop_that_nothing_answers_is_told(wheels):
    """The last one: its wiring goes."""
    wheels.robot.edit("UPDATE channel SET enabled = 0 WHERE robot = 'lbr' AND source = 'web.halt'")

    def refused() -> bool:
        try:
            status, answer = wheels.ask("POST", "/stop")
        except OSError:
            return False  # it restarts with its new wiring
        return status == 503 and "by channel rows" in answer["message"]

    until(refused)
