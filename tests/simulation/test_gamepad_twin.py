"""The emulated gamepad: the kernel's records, as `struct input_event` lays them out."""

import os
import struct
import tty

from hypothesis import given
from hypothesis import strategies as st

from lbr.capability.context import Device
from lbr.simulation.devices.gamepad import GamepadFaults
from lbr.simulation.devices.gamepad.twin import EmulatedGamepad, GamepadTwin
from tests.simulation.world_bench import AROUND

SIZE = struct.calcsize("@llHHi")


def records(data: bytes):
    return [struct.unpack("@llHHi", data[at : at + SIZE]) for at in range(0, len(data), SIZE)]


def test_what_changes_is_one_packet_with_its_time_and_then_nothing():
    pad = EmulatedGamepad(GamepadFaults(pressed=("tl",), left_y=1.0, left_trigger=0.5))
    seen = records(pad.poll(5.25))
    assert {record[:2] for record in seen} == {(5, 250_000)}
    assert sorted(record[2:] for record in seen[:-1]) == [(1, 0x136, 1), (3, 1, -32767), (3, 2, 128)]
    assert seen[-1][2:] == (0, 0, 0)
    assert pad.poll(5.3) == b""


def test_at_rest_and_out_of_range_it_says_nothing():
    assert EmulatedGamepad().poll(1.0) == b""
    pad = EmulatedGamepad(GamepadFaults(pressed=("a",), silent=True))
    assert pad.poll(1.0) == b""
    pad.hand = GamepadFaults(pressed=("a",))
    assert len(records(pad.poll(2.0))) == 2


@given(
    st.lists(st.builds(GamepadFaults, left_x=st.floats(-1, 1), dpad_y=st.floats(-1, 1), right_trigger=st.floats(0, 1)))
)
def test_whatever_a_hand_does_records_are_whole_and_values_those_of_a_pad(hands):
    pad = EmulatedGamepad()
    for hand in hands:
        pad.hand = hand
        for *_, type_, code, value in records(pad.poll(3.0)):
            assert (type_, code) in {(0, 0), (3, 0), (3, 5), (3, 0x11)}
            assert -32767 <= value <= 32767


def test_a_press_and_a_release_between_two_rounds_of_the_world_are_both_said(tmp_path):
    twin = GamepadTwin(Device("pad", "gamepad", str(tmp_path / "pad"), {}), AROUND)
    twin.service(0.0)
    descriptor = os.open(twin.port.path, os.O_RDONLY | os.O_NOCTTY)
    try:
        tty.setraw(descriptor)
        twin.fault("pressed", "tl")
        twin.fault("pressed", None)
        twin.service(1.0)
        said = [record[2:] for record in records(os.read(descriptor, 500))]
        assert said == [(1, 0x136, 1), (0, 0, 0), (1, 0x136, 0), (0, 0, 0)]
    finally:
        os.close(descriptor)
        twin.close()
