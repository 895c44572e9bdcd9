"""The emulated RIOX against what is known of its lines."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.simulation.ahrs import angles_deg, facing, from_angles
from lbr.simulation.devices.riox import RioxFaults, RioxRow
from lbr.simulation.devices.riox.twin import RioxDevice
from lbr.simulation.measured import ImuReading

FELT = ImuReading(
    gyro_rps=(0.1, -0.2, 0.3), accel_mps2=(0.0, 0.0, 9.80665), mag_ut=(20.0, 0.0, -40.0), temperature_c=30.0
)


def unit(*, echo=False, felt=FELT, **faults):
    made = RioxDevice(RioxRow(echo=echo, faults=RioxFaults(**faults)), seed=4)
    made.feel(felt, 0.0)
    return made


def ask(made, line, now=1.0):
    """What comes back within a second."""
    data = made.feed(line, now)
    return data + b"".join(made.poll(now + step / 1000) for step in range(1000))


def numbers(answer):
    return [int(part) for part in answer.split(b"=")[1].rstrip(b"\r").split(b":")]


def test_it_answers_ten_numbers_in_its_scales():
    values = numbers(ask(unit(), b"?ML\r"))
    assert values[:3] == [0, 0, 16384]
    assert values[3] == -5 * 340
    assert [value / 32.75 for value in values[4:7]] == pytest.approx([math.degrees(v) for v in FELT.gyro_rps], abs=0.1)
    assert [value * 0.3 for value in values[7:]] == pytest.approx([20.0, 0.0, -40.0], abs=0.2)


def test_level_and_facing_north_it_is_not_turned():
    assert numbers(ask(unit(), b"?QO\r")) == [16384, 0, 0, 0]
    assert numbers(ask(unit(), b"?EO\r")) == [0, 0, 0]


def test_turned_left_its_yaw_grows():
    west = ImuReading(accel_mps2=(0.0, 0.0, 9.8), mag_ut=(0.0, -20.0, -40.0))
    assert numbers(ask(unit(felt=west), b"?EO\r")) == [0, 0, 900]


def test_the_gyro_leads_between_looks_at_the_field():
    made = unit()
    for step in range(10):
        made.feel(ImuReading(gyro_rps=(0.0, 0.0, 1.0), accel_mps2=FELT.accel_mps2, mag_ut=FELT.mag_ut), step / 100)
    assert 30 < numbers(ask(made, b"?EO\r"))[2] < 52


@given(st.floats(-3.0, 3.0), st.floats(-1.4, 1.4), st.floats(-3.1, 3.1))
def test_gravity_and_field_tell_every_orientation(roll, pitch, yaw):
    w, x, y, z = from_angles(roll, pitch, yaw)

    def felt(vx, vy, vz):
        """The world's vector along the unit's axes."""
        return (
            (1 - 2 * (y * y + z * z)) * vx + 2 * (x * y + w * z) * vy + 2 * (x * z - w * y) * vz,
            2 * (x * y - w * z) * vx + (1 - 2 * (x * x + z * z)) * vy + 2 * (y * z + w * x) * vz,
            2 * (x * z + w * y) * vx + 2 * (y * z - w * x) * vy + (1 - 2 * (x * x + y * y)) * vz,
        )

    found = angles_deg(facing(felt(0, 0, 9.8), felt(20, 0, -40)))
    assert found == pytest.approx([math.degrees(roll), math.degrees(pitch), math.degrees(yaw)], abs=1e-6)


@pytest.mark.parametrize("line", [b"?XX\r", b"!M 0 0\r", b"^ECHOF 7\r", b"hello\r", b"?ML 1\r"])
def test_what_it_does_not_know_is_refused(line):
    assert ask(unit(), line) == b"-\r"


def test_it_echoes_until_told_otherwise():
    made = unit(echo=True)
    assert ask(made, b"?QO\r").startswith(b"?QO\rQO=")
    assert ask(made, b"^ECHOF 1\r", 3.0) == b"^ECHOF 1\r+\r"
    assert ask(made, b"?QO\r", 5.0).startswith(b"QO=")


@given(st.binary(max_size=80), st.booleans())
def test_whatever_it_hears_it_goes_on(data, echo):
    made = unit(echo=echo)
    made.feed(data, 1.0)
    assert b"QO=16384:0:0:0\r" in ask(made, b"\r?QO\r", 2.0)


def test_pieces_come_one_after_another():
    made = unit(pieces=True)
    made.feed(b"?QO\r", 1.0)
    seen = [data for step in range(100) if (data := made.poll(1.0 + step / 1000))]
    assert len(seen) > 2
    assert b"".join(seen) == b"QO=16384:0:0:0\r"


@pytest.mark.parametrize(
    ("fault", "answer"), [("silent", b""), ("drop", b""), ("refuse", b"-\r"), ("brown_out", b""), ("unplug", b"")]
)
def test_a_faulty_unit_answers_accordingly(fault, answer):
    assert ask(unit(**{fault: True if fault in {"silent", "brown_out", "unplug"} else 1.0}), b"?QO\r") == answer


def test_garbage_halves_and_wrong_bits_spoil_answers():
    good = b"QO=16384:0:0:0\r"
    assert ask(unit(garbage=1.0), b"?QO\r").endswith(good)
    assert good.startswith(ask(unit(half=1.0), b"?QO\r"))
    spoilt = ask(unit(bit_flip=1.0), b"?QO\r")
    assert sum((a ^ b).bit_count() for a, b in zip(spoilt, good, strict=True)) == 1


def test_frozen_it_repeats_itself_and_jumps_show():
    made = unit(frozen=True)
    made.feel(ImuReading(accel_mps2=(5.0, 0.0, 0.0)), 1.0)
    assert numbers(ask(made, b"?ML\r"))[0] == 0
    jumps = numbers(ask(unit(jump=1.0), b"?ML\r"))[6]
    assert abs(jumps / 32.75 - math.degrees(0.3)) == pytest.approx(math.degrees(4.0), abs=0.1)
