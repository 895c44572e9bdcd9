"""What a hand on a gamepad means, by rules of its own and by random histories."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.teleop.hand import REST, Hand, Twist, presses, wanted
from lbr.apps.teleop.kind import KIND, TeleopSettings
from lbr.messages.gamepad import GamepadState

SETTINGS = TeleopSettings(speed_mps=0.5, turn_rps=2.0)
NOW = 10.0
nothing = GamepadState(connected=False)


def pad(*pressed, link="usb", silent_s=0.0, **axes):
    return GamepadState(connected=True, link=link, pressed=pressed, axes=axes, silent_s=silent_s)


def moves(hand, now=NOW):
    """Return the twist of a hand, and the code of why it is not another."""
    stands = hand.stands(now)
    twist, why = (REST, stands) if stands is not None else hand.twist()
    return twist, why.code


def held(*states, settings=SETTINGS):
    """Return a hand that has heard these states, the last one now."""
    hand = Hand(settings)
    for state in states:
        hand.receive(state, NOW)
    return hand


READY = (pad(), pad("tl"))


def test_it_drives_while_the_dead_man_button_is_held_and_stands_once_it_is_let_go():
    hand = held(*READY, pad("tl", left_y=1.0))
    assert moves(hand) == (Twist(vx_mps=0.5), "done")
    hand.receive(pad(left_y=1.0), NOW)
    assert moves(hand) == (REST, "idle")


@pytest.mark.parametrize(
    ("axes", "twist"),
    [
        ({"left_y": -1.0}, Twist(vx_mps=-0.5)),
        ({"left_x": 1.0}, Twist(wz_rps=-2.0)),
        ({"right_x": -1.0}, Twist(wz_rps=2.0)),
        ({"left_x": 0.5, "right_x": -1.0}, Twist(wz_rps=2.0)),
        ({"left_y": 0.11, "left_x": -0.11}, REST),
        ({"left_y": 1.0, "right_x": 1.0}, Twist(vx_mps=0.5, wz_rps=-2.0)),
    ],
)
def test_sticks_are_a_twist_ahead_and_anticlockwise(axes, twist):
    assert wanted(axes, SETTINGS) == twist


def test_a_base_that_can_goes_sideways_and_the_other_stick_turns_it():
    settings = msgspec.structs.replace(SETTINGS, sideways=True)
    assert wanted({"left_x": 1.0}, settings) == Twist(vy_mps=-0.5)
    assert wanted({"left_x": 1.0, "left_y": 1.0}, settings).vx_mps == pytest.approx(0.354, abs=0.001)
    assert wanted({"right_x": -1.0}, settings) == Twist(wz_rps=2.0)


def test_a_stick_that_is_pushed_before_the_dead_man_button_goes_to_its_centre_first():
    hand = held(pad(left_y=1.0), pad("tl", left_y=1.0))
    assert moves(hand) == (REST, "rest_first")
    hand.receive(pad("tl"), NOW)
    hand.receive(pad("tl", left_y=1.0), NOW)
    assert moves(hand)[0].vx_mps == 0.5


def test_a_dead_man_button_that_is_held_while_it_starts_is_pressed_anew():
    hand = held(pad("tl"), pad("tl", left_y=1.0))
    assert moves(hand) == (REST, "rest_first")
    for state in (*READY, pad("tl", left_y=1.0)):
        hand.receive(state, NOW)
    assert moves(hand)[0].vx_mps == 0.5


@pytest.mark.parametrize("gone", [nothing, None])
def test_after_a_loss_nothing_moves_before_the_dead_man_button_is_pressed_anew(gone):
    hand = held(*READY, pad("tl", left_y=1.0))
    if gone is None:
        assert moves(hand, NOW + SETTINGS.stale_s + 0.01) == (REST, "stale_sensor")
    else:
        hand.receive(gone, NOW)
        assert moves(hand) == (REST, "unreachable")
    hand.receive(pad("tl"), NOW)
    hand.receive(pad("tl", left_y=1.0), NOW)
    assert moves(hand) == (REST, "rest_first")


def test_a_gamepad_on_which_nothing_is_held_is_heard_of_more_seldom_and_a_press_on_it_counts():
    hand = held(pad())
    assert moves(hand, NOW + 0.6) == (REST, "idle")
    assert hand.receive(pad("b"), NOW + 0.6) == ("b",)
    assert moves(held(pad()), NOW + 2.1) == (REST, "stale_sensor")


@pytest.mark.parametrize("now", [float("nan"), float("inf")])
def test_a_time_that_is_none_is_rest(now):
    assert moves(held(*READY, pad("tl", left_y=1.0)), now) == (REST, "stale_sensor")


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
@pytest.mark.parametrize("axis", ["left_x", "left_y", "right_x"])
def test_an_axis_that_says_what_is_no_number_is_rest(axis, value):
    assert wanted({"left_y": 1.0, axis: value}, SETTINGS) == REST
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert({"connected": True, "axes": {axis: value}}, GamepadState)


@pytest.mark.parametrize(
    ("link", "wireless", "stands"),
    [("usb", False, False), ("bluetooth", False, True), ("usb", True, True), ("other", False, False)],
)
def test_a_pad_by_radio_that_says_nothing_for_long_stands_until_it_speaks(link, wireless, stands):
    hand = held(*READY, settings=msgspec.structs.replace(SETTINGS, wireless=wireless))
    hand.receive(pad("tl", left_y=1.0, link=link, silent_s=1.9), NOW)
    assert moves(hand)[0].vx_mps == 0.5
    hand.receive(pad("tl", left_y=1.0, link=link, silent_s=2.1), NOW)
    assert (moves(hand) == (REST, "stale_sensor")) == stands
    hand.receive(pad("tl", left_y=1.0, link=link, silent_s=0.0), NOW)
    assert moves(hand)[0].vx_mps == 0.5


def test_a_button_that_stops_has_the_dead_man_button_pressed_anew():
    hand = held(*READY, pad("tl", left_y=1.0), pad("tl", "b", left_y=1.0))
    assert moves(hand) == (REST, "stopped")
    hand.receive(pad("tl", left_y=1.0), NOW)
    assert moves(hand) == (REST, "rest_first")


def test_presses_are_told_once_and_what_is_held_when_a_pad_comes_is_none():
    hand = Hand(SETTINGS)
    assert hand.receive(pad("b"), NOW) == ()
    assert hand.receive(pad("b", "y"), NOW) == ("y",)
    assert hand.receive(pad("b", "y"), NOW) == ()
    assert hand.receive(nothing, NOW) == ()
    assert hand.receive(pad("y"), NOW) == ()


def test_stops_are_asked_before_lines():
    settings = TeleopSettings(estop="x", lines={"a": "/s/hello"})
    assert presses(("a", "b", "x", "y"), settings) == ["estop", "stop", "/s/hello"]
    assert presses(("tl",), settings) == []


@pytest.mark.parametrize(
    ("row", "complaint"),
    [
        ('{"stop": "tl"}', "the button tl is to be two things"),
        ('{"lines": {"b": "s"}}', "the button b is to be two things"),
        ('{"lines": {"q": "s"}}', "Invalid enum value 'q'"),
        ('{"dead_man": ""}', "Invalid enum value ''"),
        ('{"speed_mps": 0}', "> 0.0"),
        ('{"ttl_s": 2}', "<= 1.0"),
    ],
)
def test_a_row_that_makes_no_sense_is_refused(row, complaint):
    with pytest.raises(msgspec.ValidationError, match=complaint):
        KIND.parse(row)


def test_there_is_a_row_without_a_stop_button():
    assert KIND.parse('{"stop": "", "estop": "mode"}').estop == "mode"


states = st.one_of(
    st.just(nothing),
    st.builds(
        lambda pressed, y, x: pad(*pressed, left_y=y, right_x=x),
        st.sets(st.sampled_from(["tl", "b", "a"])),
        st.sampled_from([0.0, 1.0, -1.0, 0.05]),
        st.sampled_from([0.0, 1.0, -0.5]),
    ),
)


@given(st.lists(st.tuples(states, st.floats(0.0, 0.5)), max_size=30))
def test_whatever_a_hand_does_it_moves_only_by_a_button_that_was_pressed_anew_and_is_held_and_sticks_that_were_at_rest(
    told,
):
    """The rule by itself: since the last loss, stop or gap there came a release, then the button with the sticks at rest,
    and the button has been held since."""
    hand, now, phase = Hand(SETTINGS), 0.0, "lost"
    for state, wait_s in told:
        now += wait_s
        hand.receive(state, now)
        if not state.connected:
            phase = "lost"
        elif "tl" not in state.pressed:
            phase = "released"
        elif phase != "lost" and (phase == "ready" or wanted(state.axes, SETTINGS) == REST):
            phase = "ready"
        twist, _ = moves(hand, now)
        if state.connected and {"tl", "b"} <= set(state.pressed) and phase in {"ready", "released"}:
            phase = "lost"
        assert twist == (wanted(state.axes, SETTINGS) if phase == "ready" else REST)
        if wait_s > 0.4:
            now += SETTINGS.stale_s + 0.01
            assert moves(hand, now)[0] == REST
            phase = "lost" if "tl" in state.pressed else phase
