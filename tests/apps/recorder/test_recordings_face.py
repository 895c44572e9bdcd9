"""Recordings for a page: those that have ended, for known clients alone."""

import http.client
import os
from types import SimpleNamespace

import pytest

from lbr.apps.recorder.face import RecordingsFace
from lbr.apps.recorder.recording.segments import Segment
from lbr.apps.recorder.recording.shelf import Shelf
from tests.apps.web.test_web_access import bearer, user
from tests.apps.web.web_stage import serving
from tests.support.segments import finished
from tests.support.waiting import HANG_S, until

EVE = bearer("eve") | {"X-Forwarded-For": "8.8.8.8"}
STRANGER = {"X-Forwarded-For": "8.8.8.8"}


@pytest.fixture
def folder(monkeypatch, tmp_path):
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    shelf = Shelf(tmp_path, "uxa90")
    shelf.make()
    return shelf.recordings_folder


@pytest.fixture
def served(folder, tmp_path):
    face = RecordingsFace(SimpleNamespace(name="uxa90", ctx=SimpleNamespace(home=str(tmp_path))))  # type: ignore[arg-type]
    with serving(face, users=(user("eve", "view"),), simulated=False) as found:
        yield found


def test_a_recording_that_has_ended_is_listed_and_saved_whole(served, folder):
    for name in ("first", "second"):
        with finished(Segment(folder / f"{name}.mcap", "a test", {})) as segment:
            segment.write(os.urandom(300_000))
    listed = served.ask("GET", "/recordings", headers=EVE).json
    size = (folder / "first.mcap").stat().st_size
    assert [(one["name"], one["bytes"]) for one in listed] == [("second.mcap", size), ("first.mcap", size)]
    saved = served.ask("GET", "/recordings/first.mcap", headers=EVE)
    assert (saved.status, saved.body) == (200, (folder / "first.mcap").read_bytes())
    assert "first.mcap" in saved.headers["content-disposition"]


def test_a_recording_under_way_is_not_given_out(served, folder):
    segment = Segment(folder / "open.mcap", "a test", {})
    assert served.ask("GET", "/recordings", headers=EVE).json == []
    assert served.ask("GET", "/recordings/open.mcap", headers=EVE).status == 404
    segment.finish()
    assert served.ask("GET", "/recordings/open.mcap", headers=EVE).status == 200


@pytest.mark.parametrize("name", ["none.mcap", "..%2F..%2Frobot.db", "..%2F..%2Fcredentials%2Ftoken.key"])
def test_no_other_file_is_given_out(served, name):
    assert served.ask("GET", f"/recordings/{name}", headers=EVE).status == 404


@pytest.mark.parametrize("path", ["/recordings", "/recordings/first.mcap"])
def test_to_be_at_a_place_shows_nobody_a_recording(served, path):
    assert served.ask("GET", path, headers=STRANGER).status == 401


def test_a_client_saves_two_at_once_and_others_go_on(served, folder):
    with finished(Segment(folder / "long.mcap", "a test", {})) as segment:
        segment.write(os.urandom(40_000_000))
    slow = [http.client.HTTPConnection("127.0.0.1", served.port, timeout=HANG_S) for _ in range(2)]
    try:
        for connection in slow:
            connection.request("GET", "/recordings/long.mcap", headers=EVE)
            assert connection.getresponse().status == 200
        refused = served.ask("GET", "/recordings/long.mcap", headers=EVE)
        assert (refused.status, refused.json["code"]) == (503, "busy")
        assert served.ask("GET", "/recordings", headers=EVE).status == 200
    finally:
        for connection in slow:
            connection.close()
    until(lambda: served.ask("GET", "/recordings/long.mcap", headers=EVE).status == 200)
