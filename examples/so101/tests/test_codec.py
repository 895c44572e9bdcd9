"""Bytes: the vendor's examples, the numbers of registers, and two readings of one table that must agree."""

from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lbr_so101 import table, twin
from lbr_so101.bus import PRESENT, PRESENT_BYTES, _course
from lbr_so101.model import Sts3215

from lbr.drivers.servos.protocol1 import packet

IDS = (1, 2, 3, 4, 5, 6)


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        (packet.ping(1), "FF FF 01 02 01 FB"),
        (packet.read(1, table.MODEL.address, 2), "FF FF 01 04 02 03 02 F3"),
        (packet.read(1, 56, 15), "FF FF 01 04 02 38 0F B1"),
        (packet.sync_read(56, 2, IDS), "FF FF FE 0A 82 38 02 01 02 03 04 05 06 26"),
        (packet.sync_write(42, dict.fromkeys(IDS, table.goal_bytes(2048)))[0],
         "FF FF FE 16 83 2A 02 01 00 08 02 00 08 03 00 08 04 00 08 05 00 08 06 00 08 F7"),
        (packet.sync_write(40, dict.fromkeys(IDS, table.TORQUE_ENABLE.encode(0)))[0],
         "FF FF FE 10 83 28 01 01 00 02 00 03 00 04 00 05 00 06 00 30"),
        (packet.write(1, 40, table.TORQUE_ENABLE.encode(1)), "FF FF 01 04 03 28 01 CE"),
        (packet.write(1, 41, table.ACCELERATION.encode(50) + _course(1000, 1000)),
         "FF FF 01 0A 03 29 32 E8 03 00 00 E8 03 C0"),
        (packet.write(2, 42, _course(1000, 0)), "FF FF 02 09 03 2A E8 03 00 00 00 00 DC"),
    ],
)  # fmt: skip
def test_what_is_said_is_what_the_vendor_prints(said, expected):
    assert said == bytes.fromhex(expected)


def test_a_block_of_the_vendors_is_read():
    block = bytes.fromhex("00 08 32 80 28 04")
    seen = table.motion(0x20, *(int.from_bytes(block[at : at + 2], "little") for at in (0, 2, 4)))
    assert (seen.position, seen.speed, seen.load) == (2048, -50, -40)
    assert (seen.position_rad, seen.load_fraction) == (0.0, -0.04)
    assert table.error_names(seen.error) == ("overload",)


def test_minus_zero_is_zero_and_a_goal_of_minus_100_is_a_bit_and_a_number():
    assert table.motion(0, 0x8000, 0x8000, 0x0400) == table.Motion(0, 0, 0, 0)
    assert table.goal_bytes(-100) == bytes.fromhex("64 80")


@given(st.integers(-32767, 32767))
def test_driver_and_twin_read_signs_alike(value):
    raw = int.from_bytes(table.goal_bytes(value), "little")
    assert table.goal_of(raw) == twin.signed(raw, 15) == value
    assert twin.unsigned(value, 15) == raw


@given(st.floats(-100.0, 100.0))
def test_a_position_is_one_that_the_servo_has_and_the_nearest(angle):
    raw = Sts3215().position_raw(angle)
    assert 0 <= raw <= 4095
    if -pi < angle < pi - table.RAD_PER_STEP:
        assert abs(table.position_rad(raw) - angle) <= table.RAD_PER_STEP / 2 + 1e-9


@given(st.none() | st.floats(0.0, 1000.0), st.floats(0.0, 1.0))
def test_speed_and_torque_are_what_registers_take_and_no_speed_is_not_zero(speed, torque):
    model = Sts3215()
    assert 1 <= model.speed_raw(speed) <= table.FASTEST
    assert 0 <= model.torque_raw(torque) <= 1000
    table.SPEED.encode(model.speed_raw(speed))
    table.LIMIT.encode(model.torque_raw(torque))


def test_no_torque_value_but_on_and_off_can_be_written():
    for value in (2, 128):
        with pytest.raises(ValueError, match="torque enable"):
            table.TORQUE_ENABLE.encode(value)


@given(st.binary(max_size=300), st.lists(st.integers(0, 300), max_size=5))
def test_whatever_comes_in_whatever_pieces_neither_side_breaks_and_a_sound_packet_behind_it_is_found(junk, cuts):
    bus = twin.FeetechTwin.__new__(twin.FeetechTwin)
    wanted = packet.ping(3)
    data = junk + bytes(260) + wanted
    bus._held, found = b"", []
    for first, last in zip([0, *sorted(cuts)], [*sorted(cuts), len(data)], strict=True):
        bus._held += data[first:last]
        found += list(bus._instructions())
    assert found[-1] == (3, 1, b"")


@given(st.dictionaries(st.integers(1, 6), st.integers(0, 4095), min_size=1), st.integers(0, 255))
def test_what_a_twin_says_of_several_is_what_the_parser_finds(places, error):
    parser = packet.StatusParser()
    said = b"".join(
        packet.HEADER + body + bytes((~sum(body) & 0xFF,))
        for servo, place in places.items()
        for body in [bytes((servo, PRESENT_BYTES + 2, error & 0x7F)) + place.to_bytes(2, "little") + bytes(4)]
    )
    assert [status.id for status in parser.feed(said)] == list(places)
    assert PRESENT == 56
