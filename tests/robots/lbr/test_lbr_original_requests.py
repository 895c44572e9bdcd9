"""lbr's old API over HTTP, by the real server with a robot that is nothing but answers: every documented request."""

import json
import re
import time
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from msgspec import structs

from lbr.messages.camera import SelectCommand
from lbr.messages.dock import DockHeard
from lbr.messages.drive import DriveCommand, TurnCommand
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.speech import SayCommand
from lbr.messages.telemetry import AmperagesPart, BatteryPart, CameraPart, CamerasPart, Telemetry
from tests.apps.web.test_web_access import FINGERPRINT, SECRET, user
from tests.apps.web.web_stage import Served, serving
from tests.docs.pages import ROOT
from tests.support.waiting import HANG_S, until

PAGE = ROOT / "docs" / "rest_api.md"
FACE = {"faces": ("lbr_original",)}
USERS = (user("fsm", "operate"), user("eve", "view"))
TELEMETRY = Telemetry(
    time_s=0.0,
    amperages=AmperagesPart(age_s=0.0, left_a=0.0, right_a=0.0),
    cameras=CamerasPart(
        age_s=0.0, selected="front", cameras={"front": CameraPart(device="/dev/video0", on=True, phase="streaming")}
    ),
)
TELLS = {
    "amperages": {"leftMotor": 0.0, "rightMotor": 0.0},
    "cameras": {"front": {"device": "/dev/video0", "status": "on"}, "off": {"device": "", "status": "off"}},
}
STOP = {"level": 0, "angle": 0}


def old(name: str, secret: str = SECRET) -> dict[str, str]:
    """Return the headers that a client of old shows a token by."""
    return {"User": name, "Authorization": f"TOK:{name}.{secret}.{FINGERPRINT}"}


def answer(request: str, message: Any) -> CommandReply:
    if isinstance(message, SelectCommand) and message.name not in {"front", "off"}:
        return CommandReply(accepted=False, reason="there is no such camera", code="unknown_name")
    if request.startswith("drive_"):
        return CommandReply(accepted=True, lease=message.lease or "lease", ttl_s=0.5, goal="")
    return CommandReply(accepted=True)


def prepared(served: Served) -> Served:
    served.stage.answer = answer
    served.stage.wired.add("dock_heard")
    served.stage.say("telemetry", TELEMETRY)
    return served


@pytest.fixture(scope="module")
def server() -> Iterator[Served]:
    """Serve while it is simulated, as shipped: `legacy` is open."""
    with serving(users=USERS, requests_per_s=10_000.0, **FACE) as served:
        yield prepared(served)


@pytest.fixture(scope="module")
def closed() -> Iterator[Served]:
    """Serve on hardware, as shipped."""
    with serving(users=USERS, simulated=False, **FACE) as served:
        yield prepared(served)


@pytest.fixture(autouse=True)
def at_rest(server) -> Iterator[None]:
    yield
    server.ask("POST", "/", STOP)
    server.ask("POST", "/docksignal", {"dockSignal": {"left": 0, "right": 0}})
    server.stage.say("telemetry", TELEMETRY)
    server.stage.asked.clear()


def moved(served: Served, kind: type) -> list[Any]:
    return [message for _, message in served.stage.asked if isinstance(message, kind) and not message.lease]


def without_times(found: Any) -> Any:
    return {name: {key: one for key, one in part.items() if key != "time"} for name, part in found.items()}


def test_a_motion_is_asked_for_as_documented_and_answered_with_the_telemetry(server):
    found = server.ask("POST", "/", {"turn": -90, "speech": "x"})
    assert (found.status, without_times(found.json)) == (200, TELLS)
    assert moved(server, TurnCommand) == [TurnCommand(angle_deg=-90.0, ttl_s=0.5)]
    assert [message.text for _, message in server.stage.asked if isinstance(message, SayCommand)] == ["x"]


def test_level_0_stops_by_whomever(server):
    server.ask("POST", "/", {"level": 0.3, "angle": 0})
    found = server.ask("POST", "/", STOP, {"User-Agent": "another"})
    assert (found.status, without_times(found.json)) == (200, TELLS)
    stops = [message for _, message in server.stage.asked if isinstance(message, StopCommand)]
    assert stops[-1].whole


REQUESTS: tuple[tuple[str, str, Any, int, str], ...] = (
    ("GET", "/telemetry", None, 200, "text/plain"),
    ("GET", "/telemetry/whatever", None, 200, "text/plain"),
    ("GET", "/telemetry?x=1", None, 200, "text/plain"),
    ("GET", "/cameras", None, 200, "application/json"),
    ("GET", "/validate", None, 401, "text/plain"),
    ("GET", "/", None, 404, "text/plain"),
    ("GET", "/nowhere/at/all", None, 404, "text/plain"),
    ("POST", "/nowhere", {}, 404, "text/plain"),
    ("POST", "/", {}, 400, "application/json"),
    ("POST", "/", {"speech": "hello"}, 200, "application/json"),
    ("POST", "/docksignal", {"dockSignal": {"time": 1676000000.0, "left": 1}}, 204, ""),
    ("POST", "/docksignal", {"dockSignal": {"left": 1}}, 204, ""),
    ("POST", "/docksignal", {}, 400, "application/json"),
    ("POST", "/say", {"speech": "some text"}, 200, ""),
    ("POST", "/say", {"speech": {"text": "a/b", "time": 4}}, 200, ""),
    ("POST", "/say", {}, 400, "application/json"),
    ("POST", "/wakeup", {"any": "thing"}, 204, ""),
    ("POST", "/camera/front", {}, 200, "text/plain"),
    ("POST", "/camera/off", None, 200, "text/plain"),
    ("POST", "/camera/side", {}, 404, "application/json"),
    ("OPTIONS", "/", None, 200, ""),
    ("OPTIONS", "/whatever/it/is", None, 200, ""),
    ("GET", "/index.html", None, 200, "text/html"),
    ("GET", "/snapshot.jpg", None, 503, "application/json"),
)


@pytest.mark.parametrize(("method", "path", "body", "status", "media"), REQUESTS)
def test_a_documented_request_is_answered_as_documented(server, method, path, body, status, media):
    found = server.ask(method, path, body)
    assert found.status == status, found.body
    assert found.headers.get("content-type", "").partition(";")[0] == media
    if status in {200, 204} and not media:
        assert found.body == b""


def test_texts_are_what_they_were(server):
    assert server.ask("GET", "/validate").body == b"Validation failed.\r\n"
    assert server.ask("GET", "/validate", headers=old("fsm")).body == b"Validation succeeded.\r\n"
    assert server.ask("GET", "/nothing").body == b"Service not available.\r\n"
    assert server.ask("POST", "/camera/front", {}).body == b"{}\r\n"
    assert without_times({"cameras": server.ask("GET", "/cameras").json}) == {"cameras": TELLS["cameras"]}
    assert without_times(server.ask("GET", "/telemetry").json) == TELLS
    asked = server.ask("OPTIONS", "/", headers={"Access-Control-Request-Method": "POST"}).headers
    assert asked["access-control-allow-methods"] == "GET, POST, OPTIONS"
    assert asked["access-control-allow-headers"] == "X-Requested-With, Content-type, User, Authorization"
    assert asked["access-control-allow-credentials"] == "true"


def test_what_is_refused_is_told_beside_the_telemetry(server):
    server.stage.answer = lambda request, message: (
        CommandReply(accepted=False, reason="held by console", code="held")
        if request.startswith("drive_")
        else answer(request, message)
    )
    try:
        found = server.ask("POST", "/", {"level": 0.3, "angle": 0})
    finally:
        server.stage.answer = answer
    assert (found.status, found.headers["reason-code"]) == (409, "held")
    assert found.json["refused"] == {"message": "held by console", "code": "held"}
    assert found.json["amperages"]["leftMotor"] == 0.0


def test_whether_a_camera_is_there_is_for_the_cameras_to_say_and_what_is_no_name_is_not_asked_for(server):
    for name in ("front", "off", "side", "Front", "%00", "a" * 100):
        server.ask("POST", f"/camera/{name}", {})
    asked = [message.name for _, message in server.stage.asked if isinstance(message, SelectCommand)]
    assert asked == ["front", "off", "side"]


def test_a_camera_is_switched_before_telemetry_has_told_of_any(server):
    server.stage.say("telemetry", structs.replace(TELEMETRY, cameras=None))
    assert server.ask("POST", "/camera/front", {}).status == 200
    assert server.ask("POST", "/camera/side", {}).status == 404


def test_currents_stay_as_they_were_while_the_motor_driver_begins_anew():
    def currents(left_a, volts):
        amperages = AmperagesPart(age_s=0.0, left_a=left_a, right_a=left_a)
        battery = BatteryPart(age_s=0.0, voltage_v=volts, charge=1.0, charging=False, source="battery", level="ok")
        return structs.replace(TELEMETRY, amperages=amperages, battery=battery)

    with serving(users=USERS, requests_per_s=10_000.0, **FACE) as served:
        prepared(served).stage.say("telemetry", currents(2.5, 12.6))
        before = until(lambda: served.ask("GET", "/telemetry").json.get("Bat")) and served.ask("GET", "/telemetry").json
        served.stage.say("telemetry", currents(None, 12.1))
        found = until(lambda: now if (now := served.ask("GET", "/telemetry").json)["Bat"]["voltage"] < 12.6 else None)
    assert found["amperages"] == before["amperages"]
    assert found["amperages"]["leftMotor"] == 2.5


def test_the_server_is_not_called_ready_before_its_telemetry_is_complete():
    with serving(users=USERS, **FACE) as served:
        prepared(served)
        assert not served.web.answers()
        served.stage.say("telemetry", structs.replace(TELEMETRY, complete=True))
        assert served.web.answers()


def test_a_beam_that_was_posted_counts_for_its_time_and_no_longer(server):
    server.ask("POST", "/docksignal", {"dockSignal": {"time": 5, "right": 1}})
    assert [message for _, message in server.stage.asked] == [DockHeard(right=True)]
    signal = server.ask("GET", "/telemetry").json["dockSignal"]
    assert (signal["left"], signal["right"]) == (0, 1)
    assert abs(signal["time"] - time.time()) < 60.0
    server.ask("POST", "/docksignal", {"dockSignal": {"time": 5, "right": 0, "left": 0}})
    assert "dockSignal" not in server.ask("GET", "/telemetry").json


def test_telemetry_after_a_motion_began_is_newer_than_that_or_a_second_late(server):
    server.ask("POST", "/", {"level": 0.3, "angle": 0})
    begun = time.monotonic()
    assert server.ask("GET", "/telemetry").status == 200
    late_s = time.monotonic() - begun
    assert late_s > 0.5
    server.stage.say("telemetry", TELEMETRY)
    begun = time.monotonic()
    assert server.ask("GET", "/telemetry").status == 200
    assert time.monotonic() - begun < late_s


@pytest.mark.parametrize("ending", [b"\r\n", b"\n", b""])
def test_the_wire_of_old_is_understood(server, ending):
    body = json.dumps({"level": 0.3, "angle": 0}).encode() + ending
    head = (
        f"POST / HTTP/1.0\r\nHost: 127.0.0.1\r\nContent-type: application/json\r\nContent-Length: {len(body)}\r\n\r\n"
    )
    found = server.raw(head.encode() + body)
    assert found.startswith(b"HTTP/1.1 200"), found
    assert b'"amperages"' in found


def test_a_foreign_page_gets_nothing_and_its_preflight_nothing_either(server):
    page = {"Origin": "http://evil.example"}
    for method, path in (("POST", "/"), ("OPTIONS", "/"), ("GET", "/telemetry"), ("POST", "/say")):
        assert server.ask(method, path, {} if method == "POST" else None, page).status == 403
    assert moved(server, DriveCommand) == []


def test_where_legacy_is_open_a_token_of_the_old_robot_counts_as_none(server):
    unknown = {"User": "me", "Authorization": "TOK:" + "x" * 43}
    assert server.ask("POST", "/", {"level": 0.3, "angle": 0}, unknown).status == 200
    assert server.ask("GET", "/validate", headers=unknown).status == 401
    assert server.ask("GET", "/telemetry", headers={"Authorization": "TOK:"}).status == 200
    wrong = server.ask("POST", "/", {"level": 0.3, "angle": 0}, old("fsm", "w" * 43))
    assert (wrong.status, wrong.body) == (401, b"")


@pytest.mark.parametrize("path", ["/", "/say", "/docksignal", "/wakeup", "/camera/front"])
def test_on_hardware_what_is_posted_needs_a_token_until_the_owner_says_legacy(closed, path):
    body = {"level": 0.3, "angle": 0, "speech": "x", "dockSignal": {"left": 1}}
    for shown in ({}, {"User": "me", "Authorization": "TOK:" + "x" * 43}, old("fsm", "w" * 43)):
        refused = closed.ask("POST", path, body, shown)
        assert (refused.status, refused.body, refused.headers["reason-code"]) == (401, b"", "token")
    asked = {request for request, message in closed.stage.asked if not isinstance(message, StopCommand)}
    assert asked == set()
    assert closed.ask("POST", path, body, old("fsm")).status in {200, 204}
    if path != "/wakeup":
        assert closed.ask("POST", path, body, old("eve")).status == 403
    closed.ask("POST", "/", STOP)
    closed.stage.asked.clear()


def test_everybody_at_this_machine_stops_the_robot(closed):
    for shown in ({}, old("fsm", "w" * 43), old("eve")):
        assert closed.ask("POST", "/", STOP, shown).status == 200
    assert closed.ask("POST", "/stop").status == 200


BODIES = st.binary(max_size=80) | st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=True) | st.text(max_size=10),
    lambda more: st.lists(more, max_size=3) | st.dictionaries(
        st.sampled_from(["level", "angle", "range", "sensor", "duration", "heading", "turn", "speech", "dockSignal", "left"]), more,
        max_size=5,
    ), max_leaves=6,
).map(lambda data: json.dumps(data).encode())  # fmt: skip


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.sampled_from(["/", "/say", "/docksignal", "/wakeup", "/camera/front", "/camera/%ff", "/x"]), BODIES)
def test_whatever_is_posted_is_answered_at_once_and_never_by_a_fault(server, path, body):
    begun = time.monotonic()
    found = server.ask("POST", path, body)
    assert found.status < 500, (path, body, found.body)
    assert time.monotonic() - begun < HANG_S
    if found.headers.get("content-type", "").startswith("application/json"):
        assert isinstance(json.loads(found.body), dict)


def test_the_page_has_every_path_and_no_other(server):
    table = PAGE.read_text().split("## What there is to ask")[1].split("\n## ")[0]
    told = set(
        re.findall(r"`((?:GET|POST|OPTIONS) [^` ]+)`", "\n".join(re.findall(r"^\| ([^|]+) \|", table, re.MULTILINE)))
    )
    (face,) = [one for one in server.web._faces.shown if one.name == "lbr_original"]
    parts = re.compile(r"page|signin")
    routes = {f"{route.method} {route.path}" for route in face.routes if not parts.search(route.path)}
    shown = {re.sub(r"\{(more|path):path\}", "*", route) for route in routes}
    assert told == shown
