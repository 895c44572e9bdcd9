import struct
from math import radians

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.drivers.inertial import LifeSigns
from lbr.drivers.mpu9150 import KIND, registers

ROW = KIND.parse('{"device": "imu", "gyro_range_dps": 250, "accel_range_g": 2}')
UNIT = (0.3, 0.3, 0.3)
counts16 = st.integers(-32768, 32767)


def reading(ready, field, status2):
    return struct.pack("<B3hB", ready, *field, status2)


def test_a_burst_is_big_endian_acceleration_temperature_rotation():
    burst = bytes.fromhex("4000 c000 0000 fe20 0083 ff7d 7fff")
    assert registers.decode_motion(burst) == (16384, -16384, 0, -480, 131, -131, 32767)


def test_counts_become_si_units_and_what_is_at_the_end_of_its_range_nothing():
    accel, gyro = registers.motion((16384, -16384, 0, 0, 131, -131, 0), registers.units(ROW))
    assert accel == pytest.approx((9.80665, -9.80665, 0.0))
    assert gyro == pytest.approx((radians(1), radians(-1), 0.0))
    assert registers.motion((32767, 0, 0, 0, 0, -32768, 0), registers.units(ROW)) == (None, None)


@pytest.mark.parametrize(
    ("gyro", "gyro_lsb", "accel", "accel_lsb", "codes"),
    [
        (250, 131.0, 2, 16384, b"\x00\x00"),
        (500, 65.5, 4, 8192, b"\x08\x08"),
        (1000, 32.75, 8, 4096, b"\x10\x10"),
        (2000, 16.375, 16, 2048, b"\x18\x18"),
    ],
)
def test_a_range_is_set_and_scaled_alike(gyro, gyro_lsb, accel, accel_lsb, codes):
    row = KIND.parse(f'{{"device": "imu", "gyro_range_dps": {gyro}, "accel_range_g": {accel}}}')
    units = registers.units(row)
    assert units.gyro_rps * gyro_lsb == pytest.approx(radians(1))
    assert units.accel_mps2 * accel_lsb == pytest.approx(9.80665)
    assert registers.configuration(row)[registers.SAMPLE_RATE_DIVIDER] == b"\x00\x03" + codes


def test_temperature_has_the_offset_of_the_settings():
    assert registers.temperature_c(340, ROW.temperature_offset_c) == 36.0
    assert registers.temperature_c(-340, 36.53) == pytest.approx(35.53)


def test_the_compass_is_little_endian_and_turned_onto_the_accelerometers_axes():
    field = registers.decode_field(bytes.fromhex("01 6400 ceff c800 00"), UNIT)
    assert field.trouble == ""
    assert field.microtesla == pytest.approx((-15.0, 30.0, -60.0))


def test_the_fuses_scale_each_axis_of_the_compass_itself():
    assert registers.sensitivity(bytes((128, 0, 255))) == pytest.approx((0.3, 0.15, 0.3 * (127 / 256 + 1)))
    unit = registers.sensitivity(bytes((128, 192, 64)))
    assert registers.decode_field(reading(1, (100, 100, 100), 0), unit).microtesla == pytest.approx((37.5, 30.0, -22.5))


@pytest.mark.parametrize("fuses", [b"", bytes(3), b"\xff\xff\xff", bytes(4)])
def test_fuses_that_were_not_read_are_no_sensitivity(fuses):
    assert registers.sensitivity(fuses) is None


@pytest.mark.parametrize(
    ("field", "status2", "said"),
    [((1, 2, 3), 0x08, "too strong"), ((1, 2, 3), 0x04, "data error"), ((5000, 0, 0), 0, "more than it can count")],
)
def test_a_bad_reading_of_the_compass_is_none_and_told(field, status2, said):
    found = registers.decode_field(reading(1, field, status2), UNIT)
    assert found.microtesla is None
    assert said in found.trouble


@given(st.binary(min_size=8, max_size=8))
def test_whatever_the_compass_says_is_within_its_range_or_nothing(data):
    found = registers.decode_field(data, UNIT)
    if not data[0] & 1:
        assert found is None
    elif found.microtesla is not None:
        assert not data[7] & 0x0C
        assert max(map(abs, found.microtesla)) <= 4096 * 0.3 + 1e-9
    else:
        assert found.trouble


@given(st.lists(counts16, min_size=7, max_size=7))
def test_every_burst_decodes_to_the_numbers_that_were_measured(counts):
    found = registers.decode_motion(b"".join(count.to_bytes(2, "big", signed=True) for count in counts))
    assert list(found) == counts
    accel, gyro = registers.motion(found, registers.units(ROW))
    for vector, raw, largest in ((accel, counts[:3], 19.7), (gyro, counts[4:], radians(251))):
        assert (vector is None) == bool({-32768, 32767} & set(raw))
        assert vector is None or max(map(abs, vector)) <= largest


def test_zeros_ones_and_what_repeats_are_no_signs_of_life():
    signs = LifeSigns(most_alike=3)
    assert "asleep" in signs.missing((0,) * 7)
    assert "ones" in signs.missing((-1,) * 7)
    assert [bool(signs.missing((5,) * 7)) for _ in range(5)] == [False, False, False, True, True]
    assert signs.missing((6,) * 7) == ""


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ('{"device": "imu", "gyro_range_dps": 300}', "Invalid enum value 300"),
        ('{"device": "imu", "mag_hz": 101}', "<= 100.0"),
        ('{"device": "imu", "rate_hz": 0}', ">= 10.0"),
        ('{"device": "imu", "lowpass": 5}', "unknown field `lowpass`"),
    ],
)
def test_a_bad_row_says_what_is_wrong(settings, complaint):
    with pytest.raises((msgspec.ValidationError, ValueError), match=complaint):
        KIND.parse(settings)
