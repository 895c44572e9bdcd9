"""Sighting: where a ball is, out of pictures that OpenCV looks at; when it looks, and what it says when it cannot."""

import importlib.util
from math import cos, radians, sin, tan
from pathlib import Path

import pytest

from lbr.apps.vision.sighting.kind import KIND
from lbr.messages.camera import CameraState, JpegFrame
from lbr.messages.sighting import WatchCommand
from lbr.messages.tracking import LookCommand
from lbr.testing import FakeCall, FakeContext
from tests.support import needs
from tests.support.waiting import until

needs.modules("cv2")
from tests.apps.vision.pictures_of_balls import ORANGE, picture  # noqa: E402

WIDTH, HEIGHT = 640, 360
FIELD_DEG = 72.7
DIAMETER_M = 0.14


class Stage:
    """A capability with a camera that looks 12 degrees down, and a ball before it."""

    def __init__(self, **settings):
        given = {"field_deg": FIELD_DEG, "pitch_deg": 12.0, "diameter_m": DIAMETER_M, **settings}
        self.ctx = FakeContext(KIND, KIND.settings(**given), name="sighting")
        self.sighting = KIND.load()(self.ctx)
        self.sighting.open()
        self.camera("streaming")

    def camera(self, phase):
        self.ctx.arrive(
            "camera", CameraState(on=phase != "off", phase=phase, device="front_camera"), source="camera_front"
        )

    def watch(self, target="colour", **more):
        call = FakeCall("watch", WatchCommand(target=target, **more))
        self.sighting.command(call)
        return call

    def shown(self, data, late_s=0.0):
        """Have a picture come, and return the state that tells of it."""
        self.sighting.step()
        before = len(self.states)
        looked = self.state.pictures_hz
        self.ctx.arrive("frame", JpegFrame(data), late_s=late_s)
        until(lambda: self.sighting.step() or (len(self.states) > before and self.state.pictures_hz > looked))
        return self.state

    def after(self, seconds):
        self.ctx.now += seconds
        self.sighting.step()
        return self.state

    @property
    def states(self):
        return self.ctx.said("state")

    @property
    def state(self):
        return self.states[-1]


@pytest.fixture
def stage():
    made = Stage()
    yield made
    made.sighting.close()


def seen_at(bearing_deg, away_m):
    """A picture of a ball at a bearing, so far from a camera that looks 12 degrees down."""
    ahead, left = away_m * cos(radians(bearing_deg)), -away_m * sin(radians(bearing_deg))
    down = radians(12.0)
    deep = ahead * cos(down)
    up = ahead * sin(down)
    px = WIDTH / 2 / tan(radians(FIELD_DEG / 2))
    x, y = WIDTH / 2 - left / deep * px, HEIGHT / 2 - up / deep * px
    drawn_out = (away_m / deep) ** 2  # as every picture draws what is away from its middle
    return picture((x, y, DIAMETER_M / 2 / away_m * drawn_out * px, ORANGE), width=WIDTH, height=HEIGHT)


@pytest.mark.parametrize("bearing_deg", [-30.0, 0.0, 20.0])
@pytest.mark.parametrize("away_m", [0.8, 2.5])
def test_a_ball_is_told_with_bearing_width_and_distance(stage, bearing_deg, away_m):
    assert stage.watch().answer.reason == "looks for a colour for 60 s"
    state = stage.shown(seen_at(bearing_deg, away_m))
    assert (state.watching, state.seen, state.target, state.reason) == (True, True, "colour", "")
    assert state.bearing_deg == pytest.approx(bearing_deg, abs=1.5)
    assert state.distance_m == pytest.approx(away_m, rel=0.1)
    assert state.wide_deg == pytest.approx(8.0 / away_m, rel=0.1)
    assert state.age_s == pytest.approx(0.0, abs=0.1)


def test_a_camera_that_looks_back_tells_a_bearing_of_the_robot():
    stage = Stage(yaw_deg=180.0)
    stage.watch()
    assert abs(stage.shown(seen_at(20.0, 1.5)).bearing_deg) == pytest.approx(160.0, abs=1.5)
    stage.sighting.close()


def test_without_a_diameter_no_distance_is_told():
    stage = Stage(diameter_m=None)
    stage.watch()
    state = stage.shown(seen_at(0.0, 1.0))
    assert (state.seen, state.distance_m) == (True, None)
    stage.sighting.close()


def test_what_is_old_is_not_seen_any_more(stage):
    stage.watch()
    assert stage.shown(seen_at(10.0, 1.0)).bearing_deg is not None
    state = stage.after(0.6)
    assert (state.watching, state.seen, state.bearing_deg) == (True, False, None)
    assert state.age_s == pytest.approx(0.6, abs=0.1)


def test_an_empty_picture_shows_nothing(stage):
    stage.watch()
    state = stage.shown(picture(width=WIDTH, height=HEIGHT))
    assert (state.seen, state.bearing_deg, state.reason) == (False, None, "it is not in the picture")


def test_it_reads_no_picture_unless_it_is_asked_to_look_and_stops_by_itself(stage, wording):
    taken = []
    stage.ctx.take = lambda port: taken.append(port) or []
    stage.after(1.0)
    assert not taken
    stage.watch(seconds=2.0)
    stage.after(1.0)
    assert taken == ["frame"]
    state = stage.after(1.5)
    assert not state.watching
    wording(state.reason)
    taken.clear()
    stage.after(1.0)
    assert not taken


def test_to_be_asked_again_prolongs_it_and_never_shortens_it(stage):
    stage.watch(seconds=10.0)
    stage.after(8.0)
    assert stage.watch(seconds=10.0).answer.reason == "looks for a colour for 10 s"
    assert stage.watch(seconds=1.0).answer.reason == "looks for a colour for 10 s"
    assert stage.after(8.0).watching
    assert not stage.after(3.0).watching


def test_off_ends_it_at_once(stage):
    stage.watch()
    assert stage.watch(seconds=0.0).answer.reason == "looks for nothing"
    assert not stage.state.watching


def test_without_opencv_it_says_what_to_install(stage, monkeypatch, wording):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    call = stage.watch()
    wording(call.refused)
    assert not stage.after(0.1).watching


def test_a_face_without_a_model_is_refused_with_how_to_get_one(stage):
    assert "face_model" in stage.watch("face").refused


def test_a_camera_that_is_off_is_named(stage):
    stage.camera("off")
    assert stage.watch().refused == "the camera is off: switch camera_front on"


def test_pictures_that_end_make_it_degraded_with_a_reason(stage, wording):
    stage.watch()
    stage.shown(seen_at(0.0, 1.0))
    state = stage.after(2.0)
    wording(state.reason, stage.ctx.health[-1])
    assert stage.shown(seen_at(0.0, 1.0)).seen
    assert stage.ctx.health[-1] == "ready"


def test_a_look_saves_the_picture_and_says_what_is_in_it_and_in_its_middle(stage, tmp_path):
    stage.ctx.home = str(tmp_path)
    call = FakeCall("look", LookCommand())
    stage.sighting.command(call)
    stage.ctx.arrive("frame", JpegFrame(seen_at(0.0, 1.0)))
    until(lambda: stage.sighting.step() or call.answer)
    assert call.answer.reason.startswith("sees a colour 0 % ")
    assert "the middle has hue" in call.answer.reason
    assert Path(call.answer.path).is_file()
