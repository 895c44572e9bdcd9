import importlib.util
import re
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.vision import finding, opencv
from lbr.apps.vision.sketch import sketch
from lbr.apps.vision.tracking.kind import KIND
from lbr.errors import InputError
from tests.support import needs

needs.modules("cv2")
import cv2  # noqa: E402
import numpy as np  # noqa: E402

from tests.apps.vision.pictures_of_balls import ORANGE, picture  # noqa: E402


def colour(**settings):
    return finding.finder(KIND.settings(**settings), "colour")


@pytest.mark.parametrize("x", [60.0, 580.5])
@pytest.mark.parametrize("radius", [6.0, 90.0])
@pytest.mark.parametrize("light", [0.7, 1.3])
def test_a_ball_is_found_where_it_is_in_dim_and_in_bright_light(x, radius, light):
    seen = colour()(picture((x, 200.0, radius, ORANGE), light=light))
    assert seen is not None
    left = max(0.0, radius - x)  # what the picture's edge cuts off
    assert seen.x * 640 == pytest.approx(x - 319.5 + left / 2, abs=1.5 + 0.06 * radius + left)
    assert seen.y * 640 == pytest.approx(200.0 - 239.5, abs=1.5 + 0.12 * radius)
    assert seen.radius * 640 == pytest.approx(radius, rel=0.2, abs=2.0)


@pytest.mark.parametrize("size", [(320, 240), (1280, 720)])
def test_the_size_of_the_picture_does_not_matter(size):
    width, height = size
    seen = colour()(picture((0.75 * width, 0.5 * height, 0.05 * width, ORANGE), width=width, height=height))
    assert (seen.x, seen.y, seen.radius) == pytest.approx((0.25, 0.0, 0.05), abs=0.008)


def test_without_a_ball_nothing_is_seen_and_noise_is_none():
    assert colour()(picture()) is None
    assert colour()(picture(noise=40.0)) is None


def test_other_colours_are_not_it():
    assert colour()(picture((300, 200, 40, (200, 80, 30)), (100, 100, 30, (40, 180, 60)))) is None


def test_the_larger_of_two_is_it_and_a_stripe_is_not_one():
    def stripe(image):
        image[440:470, :] = ORANGE

    seen = colour()(picture((150, 200, 20, ORANGE), (450, 200, 40, ORANGE), more=stripe))
    assert seen.x * 640 == pytest.approx(130, abs=4)


def test_a_ball_at_the_edge_is_still_one():
    seen = colour()(picture((2.0, 240.0, 40.0, ORANGE)))
    assert seen.x < -0.44


def test_a_hue_may_go_over_red():
    red = (40, 30, 220)
    assert colour(hue_deg=(345.0, 15.0))(picture((300, 200, 40, red))) is not None
    assert colour(hue_deg=(345.0, 15.0))(picture((300, 200, 40, (220, 60, 30)))) is None


@given(data=st.binary(max_size=200), at=st.integers(0, 2000), flip=st.binary(max_size=30))
def test_whatever_a_picture_is_made_of_nothing_breaks(data, at, flip):
    find = colour()
    assert find(data) is None
    whole = SMALL
    find(whole[:at])
    find(whole[:at] + flip + whole[at + len(flip) :])


SMALL = picture((40, 30, 12, ORANGE), width=80, height=60)


def test_a_picture_that_says_it_is_enormous_is_none():
    at = SMALL.index(b"\xff\xc0")
    assert opencv.decode(SMALL[: at + 5] + b"\xff\xff\xff\xff" + SMALL[at + 9 :]) is None


class Detector:
    """Stands in for OpenCV's face detector, whose model does not come with lbr."""

    def __init__(self, *faces):
        self.faces = np.array(faces, np.float32) if faces else None
        self.size = None

    def setInputSize(self, size):  # noqa: N802
        self.size = size

    def detect(self, image):
        return 1, self.faces


def test_the_largest_face_is_followed():
    detector = Detector([10, 10, 20, 20, *[0] * 10, 0.9], [180, 60, 40, 60, *[0] * 10, 0.8])
    seen = opencv.largest_face(np.zeros((240, 320, 3), np.uint8), detector)
    assert detector.size == (320, 240)
    assert (seen.x, seen.y, seen.radius) == pytest.approx((40.5 / 320, -29.5 / 320, 30 / 320))


def test_no_face_and_a_nonsensical_one_are_none():
    image = np.zeros((240, 320, 3), np.uint8)
    assert opencv.largest_face(image, Detector()) is None
    assert opencv.largest_face(image, Detector([np.nan] * 15)) is None
    assert opencv.largest_face(image, Detector([9e9, 0, 1, 1, *[0] * 10, 0.9])) is None


def test_a_face_needs_a_model_and_is_told_which(tmp_path):
    for model in ("", str(tmp_path / "none.onnx")):
        with pytest.raises(InputError, match="face_detection_yunet"):
            finding.finder(KIND.settings(face_model=model), "face")
    (tmp_path / "wrong.onnx").write_bytes(b"no model")
    with pytest.raises(InputError, match="not a model of a YuNet"):
        finding.finder(KIND.settings(face_model=str(tmp_path / "wrong.onnx")), "face")


def test_without_opencv_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "cv2", None)
    monkeypatch.delitem(sys.modules, "lbr.apps.vision.opencv")
    monkeypatch.delattr("lbr.apps.vision.opencv")
    with pytest.raises(InputError, match=r"lbr\[vision\]"):
        finding.finder(KIND.settings(), "colour")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"lbr\[vision\]"):
        finding.check(KIND.settings(), "colour")


def test_a_sketch_tells_what_is_seen_and_the_colour_of_the_middle(tmp_path):
    found = sketch(KIND.settings(), "colour", picture((320, 240, 60, ORANGE), (500, 300, 20, ORANGE), noise=2.0))
    assert "sees a colour 0 % " in found.text
    hues = re.search(r"hue (\d+) to (\d+) degrees", found.text)
    assert 10 <= int(hues[1]) <= 25 <= int(hues[2]) + 2 <= 35
    marked = cv2.imdecode(np.frombuffer(found.picture, np.uint8), cv2.IMREAD_COLOR)
    assert marked[120, 160 + 30][1] > 150  # half as large; the circle is green


def test_a_sketch_of_red_tells_hues_over_red():
    text = sketch(KIND.settings(), "colour", picture((320, 240, 60, (25, 20, 220)))).text
    low, high = map(int, re.search(r"hue (\d+) to (\d+) degrees", text).groups())
    assert low > 300
    assert high < 60
    assert text.startswith("sees no colour; ")


def test_a_sketch_of_what_is_no_picture_is_refused():
    with pytest.raises(InputError, match="cannot be read"):
        sketch(KIND.settings(), "colour", b"no picture")
