"""Rows, tokens and logs over HTTP, on a whole robot: looked at, tried, changed, and refused beside the field that is wrong."""

import json
import sqlite3
import tempfile
from contextlib import closing, suppress
from pathlib import Path

import httpx
import pytest

from lbr.testing.device import plugged
from tests.support.commands import here
from tests.support.robot import Robot, lbr, prepare, running
from tests.support.waiting import until

pytestmark = [pytest.mark.slow_start]
DRIVE = ("capability", {"name": "drive"})


@pytest.fixture(scope="module")
def robot():
    with tempfile.TemporaryDirectory(prefix="lbr-") as folder, running(prepare(Path(folder) / "h", "web")) as one:
        until(lambda: one.capability("web")["phase"] == "ready")
        yield one


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
    told = [one["text"] for one in robot.events() if one["kind"] == "edit"]
    assert any(text.startswith("web:") and "phrase 'for_a_test' (deleted)" in text for text in told)


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
    assert any("'Ann'" in one["text"] for one in robot.events())
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
    assert found["text"].endswith("the last line\n")
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
