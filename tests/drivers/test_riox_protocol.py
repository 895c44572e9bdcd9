from math import hypot, radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.drivers.echoed_lines import Value
from lbr.drivers.riox import KIND
from lbr.drivers.riox.protocol import counts_of, to_orientation, to_sample

ROW = KIND.parse('{"device": "imu"}')
MOTION = (16384, -16384, 0, 340, 131, -131, 0, 100, -50, 200)


@pytest.mark.parametrize(
    ("name", "text", "counts"),
    [
        ("QO", "16384:0:-5:1", (16384, 0, -5, 1)),
        ("ML", "1:2:3:4:5:6:7:8:9:-10", (1, 2, 3, 4, 5, 6, 7, 8, 9, -10)),
        ("ML", "1:2:3:4:5:6:7:8:9", None),
        ("ML", "1:2:3:4:5:6:7:8:9:10:11", None),
        ("ML", "1:2:3:4:5:6:7:8:9:", None),
        ("ML", "1:2:3:4:5:6:7:8:9:32768", None),
        ("ML", "1:2:3:4:5:6:7:8:9:" + "9" * 40, None),
        ("ML", "1:2:3:4:5:6:7:8:9:1.5", None),
        ("QO", "nan:0:0:0", None),
        ("QO", "1:2:3", None),
        ("L", "1:2:3:4:5:6:7:8:9:10", None),
        ("EO", "1:2:3", None),
    ],
)
def test_an_answer_is_as_many_numbers_of_16_bits_as_its_name_says(name, text, counts):
    assert counts_of(Value(name, text)) == counts


def test_the_numbers_become_si_units_by_the_scales_of_the_settings():
    sample = to_sample(MOTION, None, 5.0, ROW)
    assert (sample.valid, sample.time_s) == (True, 5.0)
    assert sample.accel_mps2 == pytest.approx((9.80665, -9.80665, 0.0))
    assert sample.gyro_rps == pytest.approx((radians(4), radians(-4), 0.0))
    assert sample.mag_ut == pytest.approx((30.0, -15.0, 60.0))
    assert sample.temperature_c == pytest.approx(36.0)
    row = KIND.parse('{"device": "imu", "accel_lsb_per_g": 8192, "gyro_lsb_per_dps": 131, "mag_ut_per_lsb": 0.15}')
    other = to_sample(MOTION, None, 5.0, row)
    assert other.accel_mps2[0] == pytest.approx(2 * 9.80665)
    assert other.gyro_rps[0] == pytest.approx(radians(1))
    assert other.mag_ut[0] == pytest.approx(15.0)


def test_what_is_at_the_end_of_its_range_is_not_measured():
    sample = to_sample((32767, *MOTION[1:5], -32768, 0, 0, 0, 0), None, 5.0, ROW)
    assert (sample.accel_mps2, sample.gyro_rps, sample.mag_ut) == (None, None, None)


@pytest.mark.parametrize("counts", [(0, 0, 0, 0), (1, 0, 0, 0), (8192, 0, 0, 0), (20000, 0, 0, 0)])
def test_an_orientation_far_from_length_one_is_none(counts):
    assert to_orientation(counts, 16384.0) is None


@given(st.tuples(*[st.integers(-16384, 16384)] * 4))
def test_an_orientation_has_length_one(counts):
    found = to_orientation(counts, 16384.0)
    if found is not None:
        assert hypot(*found) == pytest.approx(1.0)
        assert 0.89 < hypot(*counts) / 16384.0 < 1.11
