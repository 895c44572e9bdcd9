"""The thirty documented requests of the UXA-90's API, to a robot that runs: statuses, bodies, and bytes on the line.

They are asked in their order of one fresh server; ways to a place are smooth, so that of the packets that a request has
the main board read, the last is the one that is documented.
"""

import json
import re
import tempfile
import time
from pathlib import Path

import pytest

from tests.docs.pages import ROOT
from tests.fuzzing.rest_cases import served
from tests.support.uxa90_wire import chunks, packets
from tests.support.waiting import until

SLOTS = (
    """UPDATE motion SET slot_s = CASE slot WHEN 12 THEN 30 ELSE 0.2 END WHERE robot = 'uxa90' AND slot IS NOT NULL"""
)


@pytest.fixture(scope="module")
def api():
    with (
        tempfile.TemporaryDirectory(prefix="lbr-") as place,
        served(Path(place) / "h", SLOTS) as (robot, client, trace),
    ):
        yield Api(robot, client, trace)


class Api:
    def __init__(self, robot, client, trace):
        self.robot, self.client, self.trace = robot, client, trace

    def ask(self, method, url, body=None, **headers):
        media = {"Content-Type": "application/json"} if body is not None else {}
        return self.client.request(method, url, content=body, headers=media | headers)

    def read(self):
        """Return what the main board has read until now."""
        return chunks(self.trace)

    def moves(self, since):
        """Return the moves that it read after this many chunks, oldest first."""
        found, wrong = packets(b"".join(chunk.data for chunk in self.read()[since:]))
        assert wrong == []
        return [packet.data.hex(" ").upper() for packet in found if packet.kind == "move"]

    def written(self, since):
        """Return which servos were told to move in each piece that came at once."""
        return [{one.servo for one in packets(chunk.data)[0] if one.kind == "move"} for chunk in self.read()[since:]]

    def reach(self, wire, before, *request):
        """Wait until these are the last moves of their servos; a move that a busy machine broke off is asked for again."""
        asked = time.monotonic()

        def reached():
            nonlocal asked
            moves = self.moves(before)
            packets = [wire[at : at + 11] for at in range(0, len(wire), 12)]
            if all(_last(moves, packet) == packet for packet in packets):
                return True
            if time.monotonic() - asked > 1.0 and self._is_idle(0):
                asked = time.monotonic()
                self.ask(*request)
            return False

        until(reached, what=wire)

    def idle(self):
        """Wait until nothing moves or plays; what was asked for just now is known a sweep or two later."""
        first = self.client.get("/state").json()["joints"]["sequence"]
        until(lambda: self._is_idle(first + 2), what="a robot that stands still")

    def _is_idle(self, sequence):
        state = self.client.get("/state").json()
        face, joints = state["faces"]["uxa90"], state["joints"]
        return joints["sequence"] >= sequence and not (face["moving"] or face["busy"] or joints["holder"])


def neck(position):
    return {"id": 23, "name": "neck", "description": "look left/right", "position": position, "min": 1, "max": 254,
            "default": 127, "inverted": False}  # fmt: skip


def head(position):
    return {"id": 24, "name": "head", "description": "look up/down", "position": position, "min": 100, "max": 160,
            "default": 127, "inverted": False}  # fmt: skip


def moved(data, old, torq):
    return {"data": data, "message": "setMotorPos", "oldPosition": old, "newPosition": data["position"], "torq": torq}


def missing(number):
    return {"message": f"Motor '{number}' doesn't exist"}


WALK = {
    "data": {"id": 4, "name": "walk_forward_short", "button": "U"},
    "message": "callMotionById",
    "motionMsg": {"btn_code": 4},
}
BASIC = {
    "data": {"id": 1, "name": "basic_motion", "button": "A"},
    "message": "callMotionByName",
    "motionMsg": {"btn_code": 1},
}
SIT = {
    "data": {"id": 21, "name": "sit_down", "button": "0"},
    "message": "callMotionByName",
    "motionMsg": {"btn_code": 21},
}
CONTROL = {"data": {"id": 99, "name": "pc_control", "button": ""}, "motionMsg": {"motion_name": "pc_control"}}
MULTI = "setMultiMotorsPos"

EXAMPLES = [
    (3, "GET", "/motor?id=23", None, 200, {"data": neck(127), "message": "getMotorInfo"}, None),
    (4, "GET", "/motor?id=23&position=100&torq=4", None, 200, moved(neck(100), 127, 4), "FF 97 64 73"),
    (5, "GET", "/motor?id=24&pos=10", None, 200, moved(head(100), 127, 0), "FF 18 64 7C"),
    (6, "GET", "/motor?id=24&pos=300&torque=9", None, 200, moved(head(160), 100, 4), "FF 98 A0 38"),
    (7, "GET", "/motor?id=23&pos=5&position=200&torq=-3", None, 200, moved(neck(5), 100, 0), "FF 17 05 12"),
    (10, "GET", "/motor?id=20", None, 409, missing(20), None),
    (11, "GET", "/motor?id=99&pos=10", None, 409, missing(99), None),
    (12, "GET", "/motor?id=abc", None, 409, missing("NaN"), None),
    (15, "GET", "/motor?id=23&torq=2", None, 400, None, None),
    (16, "GET", "/motor?id=23&pos=abc", None, 400, None, None),
    (18, "GET", "/motion/4", None, 200, WALK, "button 04"),
    (19, "GET", "/motion/Basic_Motion", None, 200, BASIC, "button 01"),
    (20, "GET", "/motion/pc_control", None, 200, CONTROL | {"message": "callMotionByName"}, "control"),
    (21, "GET", "/motion/99", None, 200, CONTROL | {"message": "callMotionById"}, "control"),
    (22, "GET", "/motion/sit_down", None, 200, SIT, "button 15"),
    (23, "GET", "/motion/stop", None, 409, {"message": "Motion doesn't exist"}, None),
    (23, "GET", "/motion/14", None, 409, {"message": "Motion doesn't exist"}, None),
    (23, "GET", "/motion/7up", None, 409, {"message": "Motion doesn't exist"}, None),
    (23, "GET", "/motion/walk_forward_4step", None, 409, {"message": "Motion doesn't exist"}, None),
    (24, "GET", "/multimotor", '{"motors":[{"id":23,"pos":20,"torq":0},{"id":24,"pos":200}]}', 200,
     {"message": MULTI, "multiMsg": {"positions": [{"id": 23, "pos": 20, "torq": 0}, {"id": 24, "pos": 160, "torq": 0}]}},
     "FF 17 14 03 FF 18 A0 38"),
    (25, "GET", "/motor?id=23", None, 200, {"data": neck(20), "message": "getMotorInfo"}, None),
    (27, "GET", "/multimotor", '{"motors":[{"id":99,"pos":1,"torq":0}]}', 409, missing(99), None),
    (28, "GET", "/multimotor", None, 400, None, None),
    (29, "GET", "/multimotor", "{bad", 400, None, None),
]  # fmt: skip


def test_the_documented_requests_are_answered_as_documented(api):
    """In their order: each tells where the one before it has moved a joint to."""
    for example in EXAMPLES:
        _is_as_documented(api, *example)


def _is_as_documented(api, number, method, url, body, status, reply, wire):
    api.idle()
    before = len(api.read())
    answer = api.ask(method, url, body)
    assert answer.status_code == status
    found = answer.json()
    if reply is None:
        assert list(found) == ["message"]
        assert found["message"]
    else:
        assert found == reply
        assert json.dumps(found) == json.dumps({key: reply[key] for key in found})  # its keys, inner ones too, in order
    if wire is None:
        api.idle()  # a servo that gives way under its load is told its place again; head and neck have none
        assert [move for move in api.moves(before) if int(move[3:5], 16) & 31 in {23, 24}] == []
    elif wire.startswith("FF"):
        api.reach(wire, before, method, url, body)
        assert number != 24 or {23, 24} in api.written(before)
    else:
        until(lambda: wire in _frames(api, before), what=wire)


def test_1_it_says_that_it_is_there(api):
    answer = api.ask("GET", "/")
    assert (answer.status_code, answer.text, answer.headers["content-type"]) == (200, "OK", "text/plain; charset=utf-8")


def test_2_and_14_all_motors_are_listed(api):
    for url in ("/motor", "/motor?pos=10&torq=1"):
        answer = api.ask("GET", url).json()
        assert answer["message"] == "getAllMotors"
        assert [motor["id"] for motor in answer["data"]] == [*range(20), 22, 23, 24]
        assert list(answer["data"][0]) == ["id", "name", "description", "position", "min", "max", "default", "inverted"]


def test_8_and_9_a_motor_begins_out_of_its_range_as_shipped_and_is_brought_within(api):
    data = api.ask("GET", "/motor?id=14").json()["data"]
    assert (data["position"], data["min"]) == (115, 135)
    before = len(api.read())
    answer = api.ask("GET", "/motor?id=14&pos=0").json()
    assert (answer["oldPosition"], answer["newPosition"], answer["torq"]) == (115, 135, 0)
    api.reach("FF 0E 87 09", before, "GET", "/motor?id=14&pos=0")


def test_13_an_empty_id_is_motor_0(api):
    assert api.ask("GET", "/motor?id=").json()["data"]["id"] == 0


def test_17_all_motions_are_listed(api):
    answer = api.ask("GET", "/motion").json()
    assert answer["message"] == "findAll"
    assert [motion["id"] for motion in answer["data"]] == [*range(1, 14), 21, 99]
    assert answer["data"][8] == {"id": 9, "name": "walk_foward_4step", "button": "LA"}


def test_all_motors_at_once_leave_in_one_write(api):
    api.idle()
    places = dict.fromkeys((*range(20), 22, 23, 24), 127) | {4: 90, 5: 160, 14: 140, 15: 110}
    before = len(api.read())
    motors = [{"id": number, "pos": count, "torq": 3} for number, count in places.items()]
    assert api.ask("POST", "/multimotor", json.dumps({"motors": motors})).status_code == 200
    api.idle()
    assert set(places) in api.written(before)  # all of them change, by their torque already


@pytest.mark.parametrize(("method", "url"), [("POST", "/motor"), ("GET", "/nope"), ("DELETE", "/motion/4")])
def test_30_what_there_is_not_is_a_page_that_says_so(api, method, url):
    answer = api.ask(method, url)
    assert answer.status_code == 404
    assert answer.headers["content-type"].startswith("text/html")
    assert f"Cannot {method} {url}" in answer.text


def test_the_page_with_the_buttons_is_there(api):
    page = api.ask("GET", "/demo/")
    assert (page.status_code, page.headers["content-type"]) == (200, "text/html; charset=utf-8")
    for part in re.findall(r'(?:href|src)="(/[^"]+)"', page.text):
        assert api.ask("GET", part).status_code == 200


def test_a_head_request_moves_nothing(api):
    before = len(api.read())
    assert api.ask("HEAD", "/motor?id=23&pos=30").status_code == 405
    assert api.ask("HEAD", "/motion/4").status_code == 405
    assert api.ask("HEAD", "/motor?id=23").status_code == 200
    assert _last(api.moves(before), "FF 17") is None


def test_a_motion_of_key_frames_can_be_made_and_played(api):
    api.idle()
    frames = [{"duration_s": 0.3, "counts": {"24": 120}}, {"duration_s": 0.3, "positions": {"head_pitch": 0}}]
    made = api.ask("POST", "/motions", json.dumps({"id": 200, "name": "bow", "frames": frames}))
    assert made.status_code == 201
    number, version = made.json()["data"]["id"], made.headers["etag"]
    changed = api.ask(
        "PUT", f"/motions/{number}", json.dumps({"name": "bow", "frames": frames[:1]}), **{"If-Match": version}
    )
    assert changed.status_code == 200
    late = api.ask("PUT", f"/motions/{number}", json.dumps({"name": "bow", "frames": frames}), **{"If-Match": version})
    assert late.status_code == 412
    assert api.ask("PUT", "/motions/4", json.dumps({"name": "walk_forward_short", "frames": frames})).status_code == 403
    api.ask("POST", "/multimotor", '{"motors": [{"id": 24, "pos": 127}]}')
    before = len(api.read())
    until(lambda: api.ask("POST", f"/motion/{number}").status_code == 200, what="the new motion")
    api.reach("FF 18 78 60", before, "POST", f"/motion/{number}")


def test_the_page_says_what_is_answered(api):
    page = (ROOT / "docs" / "rest_api.md").read_text()
    told = re.findall(r"^```http\n(\w+) (\S+)\n(.*?)\n?\n(\d{3}) (.*?)\n```$", page, flags=re.MULTILINE | re.DOTALL)
    assert len(told) == page.count("```http")
    api.idle()
    assert api.ask("POST", "/multimotor", '{"motors":[{"id":23,"pos":127},{"id":24,"pos":127}]}').status_code == 200
    job = ""
    for method, url, body, status, reply in told:
        answer = api.ask(method, url.replace("/jobs/1", f"/jobs/{job}"), body.strip() or None)
        assert answer.status_code == int(status), (url, answer.text)
        job = answer.json().get("job", job)
        said = answer.text.replace(f'"job":"{job}"', '"job":"1"').replace(f'{{"id":"{job}"', '{"id":"1"')
        pattern = re.escape(reply).replace('"…"', "[^,}]+").replace("…", ".*")
        assert re.fullmatch(pattern, said), (url, said)


def _last(moves, like):
    """Return the last move of the same servo."""
    return next((move for move in reversed(moves) if int(move[3:5], 16) & 31 == int(like[3:5], 16) & 31), None)


def _frames(api, before):
    found, wrong = packets(b"".join(chunk.data for chunk in api.read()[before:]))
    assert wrong == []
    named = {
        "button": lambda data: f"button {data[14]:02x}",
        "frame": lambda data: "control" if data[8] == 0x10 else "",
    }
    return [named[packet.kind](packet.data) for packet in found if packet.kind in named]
