from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.drivers.servos.gate import START, first, receive, strength, tick
from lbr.messages.servos import ServoGoal, ServoSetpoint

VALID_S = 0.1


def setpoint(*goals, **fields):
    return ServoSetpoint(goals=goals or (ServoGoal(id=1, position_rad=0.1),), **fields)


def following(lease="a", now=10.0):
    state = receive(first(0.0), setpoint(lease=lease), now, now, VALID_S)
    assert state.follows
    return state


def test_a_fresh_setpoint_is_followed_and_a_late_one_is_not():
    assert following().goals[1].position_rad == 0.1
    assert (following().reason, following().code) == ("", "")
    assert tick(following(), 10.09, VALID_S) == following()
    assert not receive(first(0.0), setpoint(), 9.8, 10.0, VALID_S).follows
    assert not receive(first(0.0), setpoint(), nan, 10.0, VALID_S).follows


def test_silence_ends_the_motion_and_its_lease_is_dead_for_good():
    state = tick(following("a"), 10.15, VALID_S)
    assert not state.follows
    assert (state.reason, state.code) == ("no setpoint within 0.1 s", "no_setpoint")
    state = receive(state, setpoint(lease="a"), 10.2, 10.2, VALID_S)
    assert (state.follows, state.code) == (False, "")
    assert state.lost_since is None, "somebody cares for it, so it is not let go"
    assert receive(state, setpoint(lease="b"), 10.3, 10.3, VALID_S).follows
    followed = receive(tick(following("a"), 10.15, VALID_S), setpoint(lease="b"), 10.2, 10.2, VALID_S)
    assert (followed.follows, followed.reason, followed.code) == (True, "", "")


def test_whoever_is_lost_leaves_servos_that_hold_then_fade_then_are_let_go():
    state = receive(following(), setpoint(lost=True), 11.0, 11.0, VALID_S)
    assert state.lost_since == 11.0
    again = receive(state, setpoint(lost=True), 12.0, 12.0, VALID_S)
    assert again.lost_since == 11.0
    assert [strength(again, now, 30.0, 5.0) for now in (11.0, 41.0, 43.5, 46.0, 99.0)] == [1.0, 1.0, 0.5, 0.0, 0.0]


def test_before_any_setpoint_came_none_was_seen():
    assert not first(0.0).seen
    assert not tick(first(0.0), 99.0, VALID_S).seen
    assert following().seen


def test_while_there_is_a_sender_servos_keep_all_of_their_torque_and_then_for_as_long_as_they_hold():
    assert strength(following(), 99.0, 30.0, 5.0) == 1.0
    lost = tick(following(), 11.0, VALID_S)
    assert [strength(lost, 11.0 + after_s, 30.0, 5.0) for after_s in (29.9, 30.5, 34.5)] == pytest.approx(
        [1.0, 0.9, 0.1]
    )


def test_why_and_when_the_sender_was_lost_is_told_as_it_was_first():
    state = receive(following(), setpoint(lost=True), 11.0, 11.0, VALID_S)
    for later in (tick(state, 12.0, VALID_S), tick(state, 12.0, VALID_S, absence="'joints' is not on the bus")):
        assert (later.reason, later.lost_since) == ("the mover of the servos is lost", 11.0)
    assert tick(first(0.0), 99.0, VALID_S).reason == START
    assert tick(first(0.0), 99.0, VALID_S, absence="'joints' is not on the bus").lost_since == 0.0


def test_under_the_emergency_stop_its_reason_stays_whoever_is_lost_besides():
    state = tick(following(), 10.01, VALID_S, absence="'joints' is not on the bus", estop="button")
    assert (state.reason, state.lost_since) == ("emergency stop: button", 10.01)
    reset = tick(following(), 10.01, VALID_S, estop="button")
    reset = tick(reset, 10.02, VALID_S)
    assert (reset.estop, reset.reason) == (False, "the emergency stop was reset; waiting for a setpoint")


def test_nobody_ever_came_counts_as_lost_from_the_beginning():
    assert strength(first(0.0), 36.0, 30.0, 5.0) == 0.0


def test_the_emergency_stop_ends_the_motion_and_its_reset_moves_nothing():
    state = tick(following("a"), 10.01, VALID_S, estop="test")
    assert not state.follows
    assert "emergency stop: test" in state.reason
    state = receive(state, setpoint(lease="b"), 10.02, 10.02, VALID_S)
    assert not state.follows
    state = tick(state, 10.03, VALID_S)
    assert not state.follows
    assert state.lease == "b"
    for lease in "ab":
        assert not receive(state, setpoint(lease=lease), 10.04, 10.04, VALID_S).follows
    assert receive(state, setpoint(lease="c"), 10.04, 10.04, VALID_S).follows


def test_torque_can_be_taken_at_any_time():
    off = setpoint(ServoGoal(id=1, torque=0.0), ServoGoal(id=2))
    for state in (following(), tick(following(), 10.0, VALID_S, estop="")):
        assert receive(state, off, 10.05, 10.05, VALID_S).wanted == {2}


def test_another_number_of_stops_is_a_stop():
    state = receive(following(), setpoint(halt=3), 10.01, 10.01, VALID_S)
    assert receive(state, setpoint(halt=3), 10.02, 10.02, VALID_S).halts == state.halts
    assert receive(state, setpoint(halt=0), 10.02, 10.02, VALID_S).halts == state.halts + 1


@pytest.mark.parametrize("wrong", [{"position_rad": nan}, {"speed_rps": inf}, {"torque": nan}])
def test_one_number_of_one_goal_that_is_none_ends_the_motion_of_all(wrong):
    goals = (ServoGoal(id=1, position_rad=0.1), ServoGoal(**{"id": 2, "position_rad": 0.1} | wrong))
    state = receive(following(), setpoint(*goals, lease="a"), 10.01, 10.01, VALID_S)
    assert not state.follows
    assert not receive(state, setpoint(lease="a"), 10.02, 10.02, VALID_S).follows


def test_what_is_no_number_ends_the_motion_even_when_it_comes_late():
    state = receive(following("a"), setpoint(ServoGoal(id=1, position_rad=nan)), 9.0, 10.01, VALID_S)
    assert not state.follows
    assert not receive(state, setpoint(lease="a"), 10.02, 10.02, VALID_S).follows


def test_a_source_that_is_gone_is_lost_at_once():
    state = tick(following(), 10.0, VALID_S, absence="'joints' is not on the bus")
    assert not state.follows
    assert state.lost_since == 10.0


events = st.one_of(
    st.tuples(st.just("set"), st.sampled_from(["", "a", "b"]), st.booleans(), st.integers(0, 2)),
    st.tuples(st.just("tick"), st.sampled_from(["", "gone"]), st.sampled_from([None, "stop"])),
    st.tuples(st.just("wait"), st.floats(0.0, 0.3)),
)


@given(st.lists(events, max_size=20))
def test_a_dead_lease_never_moves_anything_again_and_nothing_is_followed_that_is_old(happened):
    state, now = first(0.0), 0.0
    for kind, *what in happened:
        if kind == "set":
            lease, lost, halt = what
            state = receive(state, setpoint(lease=lease, lost=lost, halt=halt), now, now, VALID_S)
        elif kind == "tick":
            state = tick(state, now, VALID_S, *what)
            assert not (state.follows and (what[0] or what[1] or now - state.born >= VALID_S))
        else:
            now += what[0]
        assert not (state.follows and state.lease in state.dead)
        assert not (state.follows and state.lost_since is not None)


@pytest.mark.parametrize("hold_s", [0.0, 1.0])
def test_strength_only_falls(hold_s):
    state = first(0.0)
    course = [strength(state, now / 10.0, hold_s, 2.0) for now in range(50)]
    assert course == sorted(course, reverse=True)
