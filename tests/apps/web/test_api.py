"""The robot's own API: what the robot is, its streams, its commands and its console; and who may."""

import json
import re
import socket
import time
from contextlib import contextmanager

import pytest

from lbr.apps.web import openapi
from lbr.apps.web.access import Access
from lbr.messages.leases import CommandReply
from lbr.messages.system import ConsoleResult
from tests.apps.web.api_stage import ROBOT, STANDS, StageBus, described, status
from tests.apps.web.test_web_access import bearer, user
from tests.apps.web.web_stage import REQUESTS, serving
from tests.support.waiting import until

DRIVE, LIGHT, CONSOLE = f"{ROBOT}/drive/command", f"{ROBOT}/light/switch", f"{ROBOT}/@console/page"
USERS = (user("ann", "operate"), user("eve", "view"))


@contextmanager
def api(**options):
    bus = StageBus()
    with serving(bus=bus, **{"requests_per_s": 10_000.0, "legacy": "off", **options}) as served:
        served.bus = bus
        until(lambda: served.ask("GET", "/api").status == 200, what="the robot has said what it is")
        bus.asked.clear()
        yield served


@pytest.fixture(scope="module")
def module():
    with api(users=USERS) as served:
        yield served


@pytest.fixture
def served(module):
    module.bus.asked.clear()
    module.bus.answers.clear()
    module.stage.events.clear()
    return module


def test_a_robot_says_what_it_is_and_what_its_asker_may(served):
    told = served.ask("GET", "/api").json
    assert (told["robot"], told["simulated"], told["revision"], told["role"]) == (ROBOT, True, 7, "admin")
    drive = next(one for one in told["capabilities"] if one["name"] == "drive")
    assert (drive["kind"], drive["family"], drive["summary"]) == ("drive", "operation", "moves")
    assert drive["commands"]["command"]["role"] == "operate"
    assert drive["commands"]["command"]["leased"]
    assert told["words"][0] == {"word": "f", "help": "ahead", "role": "operate", "usage": "f", "fields": []}
    assert told["cameras"] == [{"name": "front", "capability": "camera_front"}]
    assert served.ask("GET", "/api", headers=bearer("eve")).json["role"] == "view"
    assert served.ask("GET", "/api/").status == 200


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("POST", "/api/consol"),
        ("GET", "/API/console"),
        ("DELETE", "/api"),
    ],
)
def test_a_path_or_method_that_the_api_has_not_is_refused_like_all_else(served, method, path, wording):
    answer = served.ask(method, path)
    assert (answer.status, answer.json["code"]) == (404, "unknown_name")
    wording(answer.json["message"])


def test_how_capabilities_are_follows_the_status(served):
    served.bus.say("@status", status())
    phase = lambda: {one["name"]: one["phase"] for one in served.ask("GET", "/api").json["capabilities"]}  # noqa: E731
    until(lambda: phase() == {"drive": "ready", "light": "waiting", "camera_front": "waiting"})


def test_rows_that_change_are_asked_for_again():
    with api() as served:
        served.bus.robot = described(8, phrases=({"name": "hello"},))
        served.bus.say("@status", status(8))
        until(lambda: served.ask("GET", "/api").json["revision"] == 8)
        assert served.ask("GET", "/api").json["phrases"] == [{"name": "hello"}]


def test_a_stream_is_answered_with_its_newest_message_and_its_age(served):
    served.bus.answers[f"{ROBOT}/drive/state"] = lambda _said: STANDS
    answer = served.ask("GET", "/api/drive/state").json
    assert answer["message"] == STANDS
    assert 0.0 <= answer["age_s"] < 5.0


@pytest.mark.parametrize(
    "path",
    [
        "/api/drive/nothing", "/api/nothing/state", "/api/drive/command", "/api/camera_front/frame", "/api/@status/x",
        "/api/drive/@status", "/api/drive/*", "/api/**/state", "/api/drive/sta%74e%2F", "/api/..%2fdrive/state",
    ],
)  # fmt: skip
def test_what_is_no_stream_is_not_even_asked_for(served, path):
    answer = served.ask("GET", path)
    assert (answer.status, answer.json["code"]) == (404, "unknown_name")
    assert not served.bus.asked


def test_a_stream_that_says_nothing_or_no_json_is_none_now(served):
    assert served.ask("GET", "/api/drive/state").status == 404
    for rubbish in (b"{", b'{"a": NaN}', b"\xff", b'"\xff"', b"[" * 60_000):
        served.bus.answers[f"{ROBOT}/light/state"] = lambda _said, said=rubbish: said
        assert served.ask("GET", "/api/light/state").status == 404


def test_a_command_is_asked_in_the_name_of_who_asks_and_its_reply_comes_back(served):
    served.bus.answers[DRIVE] = lambda _said: CommandReply(accepted=True, lease="l1", ttl_s=0.3)
    answer = served.ask("POST", "/api/drive/command", {"power": 0.3}, bearer("ann"))
    assert (answer.status, answer.json) == (200, {"accepted": True, "lease": "l1", "ttl_s": 0.3})
    assert served.bus.asked == [(DRIVE, {"power": 0.3}, "web:ann")]
    served.ask("POST", "/api/drive/command", {"power": 0.3})
    assert served.bus.asked[-1][2] == "web:127.0.0.1"


@pytest.mark.parametrize(
    ("code", "status"), [("obstacle", 409), ("held", 409), ("malformed", 400), ("bad_value", 400), ("", 409)]
)
def test_a_refusal_has_its_code_and_sentence_in_the_words_of_all_refusals_too(served, code, status):
    served.bus.answers[LIGHT] = lambda _said: CommandReply(
        accepted=False, code=code, reason="not now", holder="web:ben"
    )
    answer = served.ask("POST", "/api/light/switch", {})
    assert answer.status == status
    assert answer.json["message"] == answer.json["reason"] == "not now"
    assert (answer.json["code"], answer.headers["reason-code"]) == (code or "refused", code or "refused")
    assert answer.json["holder"] == "web:ben"


def test_what_changes_something_and_is_not_held_is_told_with_its_askers_name(served):
    served.bus.answers[LIGHT] = lambda _said: CommandReply(accepted=True)
    assert served.ask("POST", "/api/light/switch", {"on": True}, bearer("ann")).status == 200
    until(lambda: served.stage.events)
    assert [(kind, text) for kind, text, _ in served.stage.events] == [
        ("command", 'web:ann asks light/switch: {"on":true}')
    ]


@pytest.mark.parametrize(
    ("path", "who", "status"),
    [
        ("/api/drive/command", "eve", 403), ("/api/light/switch", "eve", 403), ("/api/drive/stop", "eve", 200),
        ("/api/light/burn", "ann", 403), ("/api/light/switch", "ann", 200), ("/api/drive/command", "ann", 200),
    ],
)  # fmt: skip
def test_who_may_is_decided_before_anything_is_asked(served, path, who, status):
    served.bus.answers = dict.fromkeys((DRIVE, LIGHT, f"{ROBOT}/drive/stop"), lambda _said: CommandReply(accepted=True))
    assert served.ask("POST", path, {}, bearer(who)).status == status
    assert len(served.bus.asked) == (status == 200)


@pytest.mark.parametrize(
    ("path", "body", "headers", "status"),
    [
        ("/api/drive/nothing", {}, {}, 404), ("/api/drive/command", b"[]", {}, 400), ("/api/drive/command", b"{", {}, 400),
        ("/api/drive/command", b'{"power": NaN}', {}, 400), ("/api/drive/command", b'{"power": 1e999}', {}, 400),
        ("/api/drive/command", b"[" * 60_000, {}, 400), ("/api/drive/command", b'{"a":%s}' % (b"9" * 6000), {}, 400),
        ("/api/drive/command", b"{}", {"Content-Type": "text/plain"}, 415),
        ("/api/drive/command", b" " * 70_000, {}, 413), ("/api/console", {"line": "f" * 5000}, {}, 400),
        ("/api/console", {}, {}, 400), ("/api/console", {"line": "f", "role": "admin"}, {}, 400),
        ("/api/drive/command", {}, {"Origin": "http://evil.example"}, 403),
        ("/api/console", {"line": "f"}, {"Sec-Fetch-Site": "cross-site"}, 403),
        ("/api/console", {"line": "f"}, {"Authorization": "Bearer nobody.x.y"}, 401),
    ],
)  # fmt: skip
def test_what_is_no_command_is_not_passed_on(served, path, body, headers, status):
    given = {"Content-Type": "application/json", **headers} if isinstance(body, bytes) else headers
    assert served.ask("POST", path, body, given).status == status
    assert not served.bus.asked


def test_a_command_without_a_body_has_no_fields(served):
    served.bus.answers[f"{ROBOT}/drive/stop"] = lambda _said: CommandReply(accepted=True)
    assert served.ask("POST", "/api/drive/stop").status == 200
    assert served.bus.asked == [(f"{ROBOT}/drive/stop", {}, "web:127.0.0.1")]


def test_who_does_not_answer_is_told(served):
    answer = served.ask("POST", "/api/light/switch", {})
    assert (answer.status, answer.json["code"]) == (503, "unreachable")


@pytest.mark.parametrize(("who", "key"), [("eve", f"{CONSOLE}/view"), ("ann", f"{CONSOLE}/operate")])
def test_a_line_is_said_with_the_rights_and_the_name_of_who_says_it(served, who, key):
    served.bus.answers[key] = lambda _said: ConsoleResult(code=1, text="no", reason_code="role")
    answer = served.ask("POST", "/api/console", {"line": "wave /ä"}, bearer(who))
    assert (answer.status, answer.json["code"], answer.json["text"]) == (200, 1, "no")
    assert answer.headers["reason-code"] == "role"
    assert served.bus.asked == [(key, "wave /ä", f"web:{who}")]


@pytest.mark.parametrize(
    ("path", "body", "key"),
    [
        ("/api/drive/command", {"power": 0.3}, DRIVE),
        ("/api/light/switch", {}, f"{ROBOT}/light/switch"),
        ("/api/console", {"line": "/r/0.3/0"}, f"{CONSOLE}/admin"),
    ],
)
def test_how_long_a_request_has_waited_goes_with_it_so_that_a_stop_meanwhile_counts(served, path, body, key):
    said_slowly(served, path, body)
    assert 0.05 <= served.bus.waited_s[key] < 8.0
    assert (key, body.get("line", body)) == served.bus.asked[-1][:2]


def said_slowly(served, path, body):
    """Ask with a body that comes later than its head; return the answer."""

    def waits() -> None:
        read_s = time.monotonic()
        until(lambda: time.monotonic() > read_s + 0.05, what="a client that takes its time")

    return held_back(served, path, body, meanwhile=waits)


def held_back(served, path, body, *, meanwhile):
    """Ask with a body that comes only once something else has been done; return the answer."""
    content = json.dumps(body).encode()
    head = (
        f"POST {path} HTTP/1.1\r\nHost: 127.0.0.1:{served.port}\r\nContent-Type: application/json\r\n"
        f"Content-Length: {len(content)}\r\nExpect: 100-continue\r\nConnection: close\r\n\r\n"
    )
    with socket.create_connection(("127.0.0.1", served.port), timeout=8) as client:
        client.sendall(head.encode())
        assert b"100 Continue" in client.recv(4096)
        meanwhile()
        client.sendall(content)
        return b"".join(iter(lambda: client.recv(4096), b""))


STOPS = [("/stop", None), ("/estop", None), ("/api/drive/stop", {}), ("/api/console", {"line": "S"})]


@pytest.mark.parametrize(("stop", "said"), STOPS[2:], ids=[one for one, _ in STOPS[2:]])
def test_a_stop_is_passed_on_although_its_client_leaves_with_its_last_byte(served, stop, said):
    content = json.dumps(said).encode()
    key, words = (CONSOLE, "S") if said else (f"{ROBOT}/drive/stop", {})
    head = f"POST {stop} HTTP/1.1\r\nHost: 127.0.0.1:{served.port}\r\nContent-Type: application/json\r\n"

    def passed_on():
        return [one for asked, one, _ in served.bus.asked if asked.startswith(key)].count(words)

    for times in range(1, 9):
        with socket.create_connection(("127.0.0.1", served.port), timeout=8) as client:
            client.sendall(f"{head}Content-Length: {len(content)}\r\n\r\n".encode() + content)
            client.shutdown(socket.SHUT_RDWR)
        until(lambda times=times: passed_on() == times, what=f"stop {times} to be passed on")


@pytest.mark.parametrize(("stop", "said"), STOPS, ids=[one for one, _ in STOPS])
def test_what_came_before_its_own_clients_stop_and_is_whole_only_after_it_bears_its_own_date(served, stop, said):
    """Its sender's stop has been read by then, and is not one of another: its date alone has it begin nothing."""
    served.bus.answers[DRIVE] = lambda _said: CommandReply(accepted=True)
    served.bus.answers[f"{CONSOLE}/admin"] = lambda _said: ConsoleResult(code=0, text="done")
    served.bus.answers[f"{ROBOT}/drive/stop"] = lambda _said: CommandReply(accepted=True)
    dated: dict[str, float | None] = {}

    def stops() -> None:
        dated["stop"] = time.monotonic()
        assert served.ask("POST", stop, body=said).status in {200, 503}, "whatever the rest of the robot answers"

    held_back(served, "/api/drive/command", {"power": 0.3}, meanwhile=stops)
    assert served.bus.sent_s[DRIVE] is not None
    assert served.bus.sent_s[DRIVE] < dated["stop"]
    held_back(served, "/api/console", {"line": "/r/0.3/0"}, meanwhile=stops)
    assert served.bus.sent_s[f"{CONSOLE}/admin"] < dated["stop"]
    answer = held_back(served, "/api/light/switch", {"on": True}, meanwhile=stops)
    assert b"a stop came after this command" in answer
    assert not any(key == LIGHT for key, _, _ in served.bus.asked)
    served.ask("POST", "/api/drive/command", body={"power": 0.3})
    assert served.bus.sent_s[DRIVE] is None, "what comes after the stop is dated as it is sent"


@pytest.mark.parametrize(("path", "line"), [("/api/why", "why"), ("/api/why/drive", "/why/drive")])
def test_what_holds_a_part_still_is_asked_with_the_rights_of_who_asks(served, path, line):
    told = {"robot": ROBOT, "part": "drive", "state": "ok", "text": "Nothing is wrong: it waits for a command"}
    served.bus.answers[f"{CONSOLE}/view"] = lambda _said: ConsoleResult(code=0, text="", data=told)
    answer = served.ask("GET", path, headers=bearer("eve"))
    assert (answer.status, answer.json) == (200, told)
    assert served.bus.asked == [(f"{CONSOLE}/view", line, "web:eve")]


def test_a_part_that_is_not_there_is_not_found(served):
    served.bus.answers[f"{CONSOLE}/view"] = lambda _said: ConsoleResult(code=2, text="there is no part 'x'")
    answer = served.ask("GET", "/api/why/x", headers=bearer("eve"))
    assert (answer.status, answer.json["code"]) == (404, "unknown_name")


def test_another_user_of_this_machine_only_looks(served, monkeypatch):
    found = Access.client
    monkeypatch.setattr(Access, "client", lambda *args, **said: found(*args, **{**said, "owner": False}))
    assert served.ask("GET", "/api").json["role"] == "view"
    assert served.ask("POST", "/api/drive/command", {"power": 0.1}).status == 401


def test_the_document_has_a_path_for_each_stream_and_command_of_the_robot(served):
    document = served.ask("GET", "/openapi.json").json
    assert {
        "/api",
        "/api/console",
        "/api/why/{part}",
        "/api/drive/state",
        "/api/drive/command",
        "/api/light/switch",
    } <= set(document["paths"])
    assert "/api/camera_front/frame" not in document["paths"]
    assert not [path for path in document["paths"] if "{capability}" in path]
    operation = document["paths"]["/api/drive/command"]["post"]
    assert operation["x-role"] == "operate"
    schema = resolved(document, operation["requestBody"]["content"]["application/json"]["schema"])
    assert schema["properties"]["power"]
    newest = document["paths"]["/api/drive/state"]["get"]["responses"]["200"]["content"]["application/json"]["schema"]
    assert resolved(document, newest["properties"]["message"])["properties"]["moving"]


def test_the_document_refers_to_nothing_that_it_lacks(served):
    document = served.ask("GET", "/openapi.json").json
    references = set(re.findall(r'"\$ref": ?"([^"]+)"', json.dumps(document)))
    assert references
    for reference in references:
        assert resolved(document, {"$ref": reference})
    assert "$defs" not in json.dumps(document)
    assert document["openapi"] == openapi.VERSION


def resolved(document, schema):
    while "$ref" in schema:
        found = document
        for part in schema["$ref"].removeprefix("#/").split("/"):
            found = found[part]
        schema = found
    return schema


def test_where_there_is_no_way_onto_the_bus_the_rest_is_served():
    with serving(bus=None) as served:
        assert served.ask("GET", "/state").status == 200
        assert served.ask("GET", "/openapi.json").status == 200
        for method, path, body in (
            ("GET", "/api", None),
            ("POST", "/api/drive/stop", {}),
            ("POST", "/api/console", {"line": "f"}),
        ):
            assert served.ask(method, path, body).status == 503


def test_who_wants_what_another_holds_asks_for_it_and_is_told_that_it_is_handed_over():
    with api(users=USERS) as served:
        asked = served.ask("POST", "/api/ask", {"capability": "drive"}, bearer("ann"))
        assert asked.status == 200
        given = {"capability": "drive", "to": "web:ann"}
        assert served.ask("POST", "/api/hand_over", given).status == 200
        until(lambda: len(served.stage.event_data) >= 2)
        assert ("asked_for", {"capability": "drive", "by": "web:ann"}) in served.stage.event_data
        assert ("handed_over", {"by": "web:127.0.0.1", **given}) in served.stage.event_data
        assert not served.bus.lent.moves
        again = served.ask("POST", "/api/ask", {"capability": "drive"}, bearer("ann"))
        assert (again.status, again.json["code"]) == (429, "busy"), "a sentence in the events of all"
        for nothing in ("light", "camera_front", "none"):
            assert served.ask("POST", "/api/ask", {"capability": nothing}).status == 404
        assert served.ask("POST", "/api/ask", {"capability": "drive"}, bearer("eve")).status == 403


def test_what_can_be_held_and_is_not_wired_to_a_stop_is_stopped_by_the_console(served):
    """What can be held and is not wired to a stop is stopped by the console"""
    key = f"{CONSOLE}/view"
    served.bus.answers[key] = lambda said: ConsoleResult(code=0, text="stopped") if said == "stop" else None
    assert served.ask("POST", "/stop").json == {"message": "stopped"}
    assert (key, "stop", "web:127.0.0.1") in served.bus.asked
    served.bus.answers[key] = lambda _said: ConsoleResult(code=1, text="'drive' hangs", reason_code="timeout")
    answer = served.ask("POST", "/stop")
    assert (answer.status, answer.json) == (409, {"message": "'drive' hangs", "code": "timeout"})
    served.bus.answers[key] = lambda _said: None
    assert served.ask("POST", "/stop").status == 503
    served.stage.wired.clear()
    served.bus.answers[key] = lambda _said: ConsoleResult(code=0, text="stopped")
    try:
        assert served.ask("POST", "/stop").json == {"message": "stopped"}
    finally:
        served.stage.wired.update(REQUESTS)


@pytest.mark.parametrize("away", [None, CommandReply(accepted=False, reason="'drive' ends", code="shutting_down")])
def test_a_stop_of_what_restarts_is_the_consoles_which_asks_its_next_process(served, monkeypatch, away):
    monkeypatch.setattr(served.stage, "targets", lambda _request: ("drive",))
    line = (f"{CONSOLE}/view", "stop", "web:127.0.0.1")
    assert served.ask("POST", "/stop").json == {"message": "stopped"}
    assert line not in served.bus.asked
    monkeypatch.setattr(served.stage, "answer", lambda _request, _message: away)
    assert served.ask("POST", "/stop").json == {"message": "stopped"}
    assert line in served.bus.asked
    silent = ConsoleResult(code=1, text="'drive' did not answer; it is starting", reason_code="unreachable")
    served.bus.answers[line[0]] = lambda _said: silent
    answer = served.ask("POST", "/stop")
    assert (answer.status, answer.json["code"]) == (503, "unreachable")
