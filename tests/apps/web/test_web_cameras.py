"""Cameras as a face: who may see, what a cookie is good for, and pictures from a camera to a browser."""

import http.client
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from lbr.messages.camera import CameraState, JpegFrame
from tests.apps.navcam.test_navcam import PART, jpeg, next_mark
from tests.apps.web.test_web_access import bearer, user
from tests.apps.web.test_web_hostile import asked_as_another
from tests.apps.web.test_web_server import Plain
from tests.apps.web.web_stage import Answer, Served, serving
from tests.support.robot import prepare, running
from tests.support.waiting import HANG_S, until

ON = CameraState(on=True, phase="streaming", device="/dev/video0")
PRIVATE = ("/index.html", "/stream.mjpg", "/snapshot.jpg", "/cameras", "/page.js")


@pytest.fixture
def served(monkeypatch, tmp_path) -> Iterator[Served]:
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    users = (user("ann", "operate"), user("eve", "view"))
    with serving(Plain(), faces=("cameras",), users=users, simulated=False, requests_per_s=4000.0) as found:
        found.stage.bring("cameras", "camera_front", ON)
        found.stage.bring("cameras", "camera_rear", CameraState(on=False, phase="off", device="/dev/video2"))
        until(lambda: "cameras" not in found.stage.came, what="a round that reads them")
        yield found


STRANGER = {"X-Forwarded-For": "8.8.8.8"}


def signed_in(served: Served, name: str = "ann") -> dict[str, str]:
    """Return what a browser shows that was given a cookie, and that nobody here knows otherwise."""
    answer = served.ask("POST", "/session", headers=bearer(name) | STRANGER)
    assert answer.status == 204
    assert "HttpOnly" in answer.headers["set-cookie"]
    assert "SameSite=strict" in answer.headers["set-cookie"]
    return {"Cookie": answer.headers["set-cookie"].partition(";")[0]} | STRANGER


@contextmanager
def watching(served: Served, headers: dict[str, str], path: str = "/stream.mjpg") -> Iterator[Any]:
    """Open a stream, and show pictures to it until the end of a `with`."""
    connection = http.client.HTTPConnection("127.0.0.1", served.port, timeout=8)
    connection.request("GET", path, headers=headers)
    over = threading.Event()

    def show() -> None:
        mark = 0
        while not over.wait(0.01):
            mark += 1
            served.stage.bring("frames", "camera_front", JpegFrame(jpeg(mark)))

    showing = threading.Thread(target=show)
    showing.start()
    try:
        with connection.getresponse() as response:
            yield response
    finally:
        over.set()
        showing.join()
        connection.close()


def test_the_owner_and_who_shows_a_token_sees(served):
    for headers in ({}, bearer("eve"), bearer("eve") | STRANGER, signed_in(served)):
        assert served.ask("GET", "/cameras", headers=headers).json["rear"]["status"] == "off"
        assert b"<title>lbr Navigation</title>" in served.ask("GET", "/index.html", headers=headers).body
        served.stage.bring("frames", "camera_front", JpegFrame(jpeg(7)))
        picture = served.ask("GET", "/snapshot.jpg?camera=front", headers=headers)
        assert (picture.status, picture.body) == (200, jpeg(7))
        assert picture.headers["content-type"] == "image/jpeg"


@pytest.mark.parametrize("path", PRIVATE)
def test_to_be_at_a_place_lets_nobody_see(served, path):
    assert asked_as_another(served, "GET", path) == 401
    assert served.ask("GET", path, headers=STRANGER).status == 401
    assert served.ask("GET", path, headers=STRANGER | {"Cookie": f"lbr_web_{served.port}=nonsense"}).status == 401


def test_a_trusted_network_and_the_old_api_let_nobody_see():
    with serving(faces=("cameras",), legacy="on", trusted=("127.0.0.0/8",)) as served:
        for path in PRIVATE:
            assert asked_as_another(served, "GET", path) == 401


def test_who_is_unknown_is_shown_where_to_sign_in(served):
    answer = served.ask("GET", "/index.html", headers=STRANGER)
    assert (answer.status, b"signin.js" in answer.body) == (401, True)
    assert answer.headers["www-authenticate"] == 'Bearer realm="lbr"'
    assert served.ask("GET", "/signin.js", headers=STRANGER).status == 200
    assert served.ask("POST", "/session", headers=STRANGER).status == 401
    assert served.ask("POST", "/session").said.startswith("show the token itself")


def test_a_cookie_looks_and_stops_and_does_nothing_else(served):
    cookie = signed_in(served)
    assert served.ask("GET", "/state", headers=cookie).status == 200
    assert served.ask("POST", "/stop", headers=cookie).status == 200
    served.stage.asked.clear()
    for method, path in (("GET", "/move"), ("POST", "/estop/reset"), ("POST", "/session")):
        for more in ({}, {"Sec-Fetch-Site": "none"}, {"Origin": f"http://127.0.0.1:{served.port}"}):
            assert served.ask(method, path, headers=cookie | more).status == 401, (method, path)
    assert served.stage.asked == []


def test_a_cookie_is_good_for_the_user_alone_whose_browser_was_given_it(served):
    cookie = {"Cookie": signed_in(served)["Cookie"]}
    for method, path in (("GET", "/cameras"), ("GET", "/stream.mjpg"), ("DELETE", "/sessions")):
        assert asked_as_another(served, method, path, **cookie) == 401
    assert asked_as_another(served, "DELETE", "/session", **cookie) == 204  # it ends nothing that is not their own
    assert served.ask("GET", "/cameras", headers=cookie | STRANGER).status == 200


@pytest.mark.parametrize("page", [{"Origin": "http://evil.example"}, {"Sec-Fetch-Site": "cross-site"}])
def test_a_foreign_page_sees_nothing_by_a_browsers_cookie(served, page):
    cookie = signed_in(served)
    for path in PRIVATE[1:]:
        assert served.ask("GET", path, headers=cookie | page).status == 403
    assert served.ask("DELETE", "/sessions", headers=cookie | page).status == 403
    assert served.ask("GET", "/cameras", headers=cookie).status == 200


def test_there_is_no_picture_of_what_is_off_or_old_or_gone(served, wording):
    assert served.ask("GET", "/snapshot.jpg").status == 503
    served.stage.bring("frames", "camera_front", JpegFrame(jpeg(1)), age_s=1.5)
    wording(served.ask("GET", "/snapshot.jpg").said, served.ask("GET", "/stream.mjpg?camera=side").said)
    served.stage.dead.add("camera_rear")
    assert set(served.ask("GET", "/cameras").json) == {"front"}


def test_pictures_come_as_they_are_made_and_who_watches_is_told(served):
    with watching(served, bearer("eve"), "/stream.mjpg?camera=front") as response:
        assert response.headers["Content-Type"] == "multipart/x-mixed-replace; boundary=FRAME"
        assert response.read(len(PART)) == PART
        marks = [next_mark(response) for _ in range(5)]
        assert marks == sorted(set(marks))
        assert served.ask("GET", "/snapshot.jpg").status == 200
    until(lambda: ("watched", "eve at 127.0.0.1 watches front no more", "info") in served.stage.events)
    assert ("watched", "eve at 127.0.0.1 watches front", "info") in served.stage.events


def test_who_signs_out_sees_nothing_more_and_others_do(served):
    mine, theirs = signed_in(served), signed_in(served, "eve")
    with watching(served, mine) as response:
        response.read(len(PART))
        next_mark(response)
        out: Answer = served.ask("DELETE", "/session", headers=mine)
        assert (out.status, "Max-Age=0" in out.headers["set-cookie"]) == (204, True)
        while response.read(4096):
            pass
    assert served.ask("GET", "/cameras", headers=mine).status == 401
    assert served.ask("GET", "/cameras", headers=theirs).status == 200
    again = signed_in(served, "eve")
    assert served.ask("DELETE", "/sessions", headers=theirs).status == 204
    assert served.ask("GET", "/cameras", headers=again).status == 401


def test_streams_end_with_the_server(monkeypatch, tmp_path):
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    with serving(faces=("cameras",)) as served:
        connection = http.client.HTTPConnection("127.0.0.1", served.port, timeout=8)
        connection.request("GET", "/stream.mjpg")
        response = connection.getresponse()
        assert response.read(len(PART)) == PART
    assert response.read() == b""
    connection.close()


@pytest.mark.slow_start
def test_a_robots_camera_is_seen_by_its_own_server(tmp_path):
    home = prepare(tmp_path / "home", "camera_front", "cameras", "web")
    with running(home) as robot:
        until(lambda: robot.capability("web")["phase"] == "ready")

        def answer(path: str) -> tuple[int, bytes]:
            connection = http.client.HTTPConnection(robot.web.removeprefix("http://"), timeout=HANG_S)
            try:
                connection.request("GET", path)
                found = connection.getresponse()
                return found.status, found.read()
            finally:
                connection.close()

        seen = until(lambda: (got := answer("/snapshot.jpg"))[0] == 200 and got, what="a picture")
        assert seen[1].startswith(b"\xff\xd8")
        assert b'"front":{"status":"on"' in answer("/cameras")[1]
        robot.line("/camera/off")
        until(lambda: answer("/snapshot.jpg")[0] == 503, what="a camera that is off")
