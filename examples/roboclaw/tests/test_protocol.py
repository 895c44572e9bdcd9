"""The encoding of the packets, against examples worked out by hand and any bytes."""

from binascii import crc_hqx

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lbr_roboclaw import protocol as wire

COMMANDS = st.sampled_from(sorted(wire.SIZES))


def test_the_checksum_is_that_of_ccitt():
    assert crc_hqx(b"123456789", 0) == 0x31C3
    assert wire.request(0x80, 21) == bytes((0x80, 21)) + crc_hqx(bytes((0x80, 21)), 0).to_bytes(2, "big")


@pytest.mark.parametrize(
    ("powers", "data"),
    [((0.0, 0.0), "00000000"), ((1.0, -1.0), "7fff8001"), ((0.5, -0.5), "4000c000"), ((2.0, -9.0), "7fff8001")],
)
def test_power_is_a_share_of_full_scale_and_never_more(powers, data):
    assert wire.duty(0x81, *powers)[:-2].hex() == "8122" + data


@given(COMMANDS, st.binary(max_size=60))
def test_what_comes_is_an_answer_only_with_its_checksum(command, heard):
    data = wire.answered(0x80, command, heard)
    if data is not None:
        asked = crc_hqx(bytes((0x80, command)), 0)
        assert len(data) in wire.SIZES[command]
        assert heard[len(data) : len(data) + 2] == crc_hqx(data, asked).to_bytes(2, "big")


@given(COMMANDS, st.data())
def test_a_whole_answer_is_understood_and_no_part_of_it(command, data):
    size = data.draw(st.sampled_from(list(wire.SIZES[command])))
    said = data.draw(st.binary(min_size=size, max_size=size))
    if command == wire.VERSION:
        said = said[:-1].replace(b"\0", b" ") + b"\0"
    whole = said + crc_hqx(bytes((0x80, command)) + said, 0).to_bytes(2, "big")
    assert wire.answered(0x80, command, whole) is not None
    assert wire.answered(0x80, command, whole[: size + 1]) in {None, said[:2]}
    assert wire.answered(0x81, command, whole) is None or command == wire.STATUS


@pytest.mark.parametrize(
    ("status", "names"),
    [
        ("00000000", ()),
        ("00000001", ("emergency_stop",)),
        ("00000022", ("overheat", "logic_undervoltage")),
        ("003f0000", ()),
        ("0004", ("emergency_stop",)),
        ("0300", ("driver_m1", "driver_m2")),
    ],
)
def test_faults_have_names_and_warnings_are_none(status, names):
    assert wire.faults(bytes.fromhex(status)) == names
