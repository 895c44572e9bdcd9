from math import isfinite
from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.drivers.gamepad.nodes import gamepads, path_of
from lbr.drivers.gamepad.pad import AXES, BUTTONS, STANDARD, Pad, Span, named, way
from lbr.drivers.input_events import EV_ABS, EV_KEY, EV_SYN, SYN_DROPPED, SYN_REPORT, InputEvent
from lbr.messages.gamepad import Axis, Button

A, TL, X, Y, HAT0Y = 0x130, 0x136, 0, 1, 0x11
ints = st.integers(-(2**31), 2**31 - 1)
END = (EV_SYN, SYN_REPORT, 0)


def events(*told):
    return [InputEvent(type_, code, value, 5.0) for type_, code, value in told]


def test_a_packet_is_told_once_it_is_whole():
    pad = Pad()
    assert pad.feed(events((EV_KEY, TL, 1), (EV_ABS, Y, -32768))) == []
    (held,) = pad.feed(events(END))
    assert held.pressed == ("tl",)
    assert held.axes["left_y"] == 1.0
    assert held.axes["left_x"] == 0.0


def test_a_press_however_short_is_told():
    told = Pad().feed(events((EV_KEY, A, 1), END, (EV_KEY, A, 0), END))
    assert [held.pressed for held in told] == [("a",), ()]


def test_after_a_hole_nothing_counts_until_the_kernel_has_told_what_is_held():
    pad = Pad()
    told = pad.feed(events((EV_KEY, TL, 1), END, (EV_SYN, SYN_DROPPED, 0), (EV_KEY, TL, 0), (EV_ABS, X, 9), END))
    assert [held.pressed for held in told] == [("tl",)]
    assert pad.unknown
    pad.tell({X: 32767}, [A, 0x2FF])
    assert not pad.unknown
    assert pad.held().pressed == ("a",)
    assert pad.held().axes["left_x"] == 1.0
    assert len(pad.feed(events((EV_KEY, A, 0), END))) == 1


def test_a_hat_is_buttons_too():
    (held,) = Pad().feed(events((EV_ABS, HAT0Y, -1), END))
    assert held.pressed == ("dpad_up",)
    assert held.axes["dpad_y"] == 1.0


@given(ints, st.builds(Span, ints, ints, ints), st.sampled_from(get_args(Axis)))
def test_whatever_a_pad_says_of_its_axes_a_way_is_a_number_within_its_bounds(value, span, axis):
    found = way(value, span, axis)
    assert isfinite(found)
    assert (0.0 if "trigger" in axis else -1.0) <= found <= 1.0


@given(st.integers(0, 40), st.integers(1, 2**20))
def test_what_is_within_the_flat_part_is_rest_and_the_ends_are_full(flat, half):
    span = Span(-half, half, flat)
    assert way(min(flat, half // 2), span, "left_x") == 0.0
    assert way(half, span, "left_x") == 1.0
    assert way(-half, span, "left_x") == -1.0
    assert way(-half, span, "left_y") == 1.0


@given(st.lists(st.tuples(st.sampled_from([EV_SYN, EV_KEY, EV_ABS, 4, 0x15]), st.integers(0, 0x2FF), ints)))
def test_whatever_comes_is_held_within_bounds(told):
    for held in Pad(STANDARD).feed(events(*told)):
        assert set(held.pressed) <= set(get_args(Button))
        assert all(axis in get_args(Axis) and -1.0 <= value <= 1.0 for axis, value in held.axes.items())


@pytest.mark.parametrize(
    ("codes", "right", "triggers"),
    [
        ((0, 1, 2, 3, 4, 5), {3: "right_x", 4: "right_y"}, {2: "left_trigger", 5: "right_trigger"}),
        ((0, 1, 2, 5), {2: "right_x", 5: "right_y"}, {}),
        ((0, 1, 2, 5, 9, 10), {2: "right_x", 5: "right_y"}, {9: "right_trigger", 10: "left_trigger"}),
        ((0, 1, 3, 4, 0x14, 0x15), {3: "right_x", 4: "right_y"}, {0x14: "right_trigger", 0x15: "left_trigger"}),
    ],
)
def test_axes_are_named_as_pads_have_them(codes, right, triggers):
    assert named(codes) == {0: "left_x", 1: "left_y"} | right | triggers


def test_every_button_has_a_name_and_one_code():
    assert sorted(BUTTONS.values()) == sorted(get_args(Button))
    assert len(set(AXES)) == len(AXES)


def device(sys, node, name, *, keys, axes, uniq=""):
    place = sys / node / "device" / "capabilities"
    place.mkdir(parents=True)
    (place.parent / "name").write_text(f"{name}\n")
    (place.parent / "uniq").write_text(f"{uniq}\n")
    words = [keys >> 64 * at & (2**64 - 1) for at in range(5)]
    (place / "key").write_text(" ".join(f"{word:x}" for word in reversed(words)))
    (place / "abs").write_text(f"{axes:x}")


def test_gamepads_are_found_by_what_the_kernel_says_of_them_and_again_by_radio_or_name(tmp_path):
    device(tmp_path, "event2", "Keyboard", keys=1 << 30, axes=0)
    device(tmp_path, "event10", "Stick", keys=1 << 0x120, axes=0b11)
    device(tmp_path, "event3", "Wireless Controller Touchpad", keys=1 << 0x14A, axes=0b11, uniq="aa:bb:cc:00:11:22")
    device(tmp_path, "event4", "Wireless Controller", keys=1 << 0x130, axes=0b111111, uniq="aa:bb:cc:00:11:22")
    assert [one.node for one in gamepads(tmp_path)] == ["event4", "event10"]
    assert [one.address for one in gamepads(tmp_path)] == ["input:aa:bb:cc:00:11:22", "input:Stick"]
    assert path_of("input:AA:BB:CC:00:11:22", tmp_path) == "/dev/input/event4"
    assert path_of("input:stick", tmp_path) == "/dev/input/event10"
    assert path_of("input:", tmp_path) == ""
    assert path_of("/dev/input/event7", tmp_path) == "/dev/input/event7"
