from math import hypot, radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.drivers.riox import KIND
from lbr.drivers.riox.protocol import (
    MAX_LINE_BYTES,
    Answer,
    BadLine,
    Echo,
    Refused,
    ReplyParser,
    encode_query,
    to_orientation,
    to_sample,
)

ROW = KIND.parse('{"device": "imu"}')
MOTION = (16384, -16384, 0, 340, 131, -131, 0, 100, -50, 200)
counts16 = st.integers(-32768, 32767)


def spelt(name, counts):
    return f"{name}={':'.join(map(str, counts))}\r".encode()


def test_a_query_is_its_name_and_a_carriage_return():
    assert (encode_query("ML"), encode_query("QO")) == (b"?ML\r", b"?QO\r")


@pytest.mark.parametrize(
    ("line", "reply"),
    [
        (b"?ML\r", Echo("ML")),
        (b"?QO\r\n", Echo("QO")),
        (b"-\r", Refused()),
        (b"QO=16384:0:-5:1\r", Answer("QO", (16384, 0, -5, 1))),
        (b"ML=1:2:3:4:5:6:7:8:9:-10\r\n", Answer("ML", (1, 2, 3, 4, 5, 6, 7, 8, 9, -10))),
    ],
)
def test_a_line_is_a_reply(line, reply):
    assert ReplyParser().feed(line) == [reply]


@pytest.mark.parametrize(
    "line",
    [
        b"ML=1:2:3:4:5:6:7:8:9",
        b"ML=1:2:3:4:5:6:7:8:9:10:11",
        b"ML=1:2:3:4:5:6:7:8:9:",
        b"ML=1:2:3:4:5:6:7:8:9:32768",
        b"ML=1:2:3:4:5:6:7:8:9:" + b"9" * 400,
        b"ML=1:2:3:4:5:6:7:8:9:1.5",
        b"QO=nan:0:0:0",
        b"QO=1:2:3",
        b"L=1:2:3:4:5:6:7:8:9:10",
        b"EO=1:2:3",
        b"+",
        b"\xff\x00",
        b"?M",
        b"ML=" + b"1:" * 1000,
    ],
)
def test_what_is_damaged_is_a_bad_line(line):
    assert [type(reply) for reply in ReplyParser().feed(line + b"\r")] == [BadLine]


def test_the_numbers_become_si_units_by_the_scales_of_the_settings():
    sample = to_sample(Answer("ML", MOTION), None, 5.0, ROW)
    assert (sample.valid, sample.time_s) == (True, 5.0)
    assert sample.accel_mps2 == pytest.approx((9.80665, -9.80665, 0.0))
    assert sample.gyro_rps == pytest.approx((radians(4), radians(-4), 0.0))
    assert sample.mag_ut == pytest.approx((30.0, -15.0, 60.0))
    assert sample.temperature_c == pytest.approx(36.0)
    row = KIND.parse('{"device": "imu", "accel_lsb_per_g": 8192, "gyro_lsb_per_dps": 131, "mag_ut_per_lsb": 0.15}')
    other = to_sample(Answer("ML", MOTION), None, 5.0, row)
    assert other.accel_mps2[0] == pytest.approx(2 * 9.80665)
    assert other.gyro_rps[0] == pytest.approx(radians(1))
    assert other.mag_ut[0] == pytest.approx(15.0)


def test_what_is_at_the_end_of_its_range_is_not_measured():
    sample = to_sample(Answer("ML", (32767, *MOTION[1:5], -32768, 0, 0, 0, 0)), None, 5.0, ROW)
    assert (sample.accel_mps2, sample.gyro_rps, sample.mag_ut) == (None, None, None)


@pytest.mark.parametrize("counts", [(0, 0, 0, 0), (1, 0, 0, 0), (8192, 0, 0, 0), (20000, 0, 0, 0)])
def test_an_orientation_far_from_length_one_is_none(counts):
    assert to_orientation(Answer("QO", counts), 16384.0) is None


@given(st.tuples(*[st.integers(-16384, 16384)] * 4))
def test_an_orientation_has_length_one(counts):
    found = to_orientation(Answer("QO", counts), 16384.0)
    if found is not None:
        assert hypot(*found) == pytest.approx(1.0)
        assert 0.89 < hypot(*counts) / 16384.0 < 1.11


@given(st.lists(counts16, min_size=10, max_size=10), st.lists(counts16, min_size=4, max_size=4), st.data())
def test_what_a_unit_says_is_read_in_pieces_of_any_size(motion, orientation, data):
    said = b"?QO\r" + spelt("QO", orientation) + b"\n?ML\r" + spelt("ML", motion)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(said)), max_size=6)))
    parser = ReplyParser()
    pieces = [said[a:b] for a, b in zip([0, *cuts], [*cuts, len(said)], strict=True)]
    replies = [reply for piece in pieces for reply in parser.feed(piece)]
    assert replies == [Echo("QO"), Answer("QO", tuple(orientation)), Echo("ML"), Answer("ML", tuple(motion))]


@given(st.lists(st.binary(max_size=400) | st.sampled_from([b"ML=", b"1:", b"\r", b"-", b"QO=1:2:3:4\r"]), max_size=12))
def test_noise_is_bad_lines_at_most_and_never_held_without_end(pieces):
    parser = ReplyParser()
    for piece in pieces:
        for reply in parser.feed(piece):
            assert isinstance(reply, Answer | Echo | Refused | BadLine)
        assert parser.held_bytes <= MAX_LINE_BYTES
    parser.reset()
    assert parser.feed(b"-\r") == [Refused()]
