"""When two runs of a robot did the same: numbers within a time and a share of their span, and what happened, each once."""

import math

from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.recorder.rerun import alike
from lbr.apps.recorder.rerun.alike import CodedEvent

MS = 1_000_000
series = st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=80).map(
    lambda values: [(turn * 20 * MS, {"left": value}) for turn, value in enumerate(values)]
)


@given(series, st.integers(-300, 300))
def test_the_same_a_moment_later_is_alike(then, later_ms):
    assert not alike.differences(then, [(at + later_ms * MS, values) for at, values in then])


@given(series, st.data())
def test_what_is_beyond_all_that_was_is_a_difference(then, data):
    at = data.draw(st.integers(0, len(then) - 1))
    now = [*then[:at], (then[at][0], {"left": 2.0}), *then[at + 1 :]]
    assert ("left", 2.0) in [(one.field, one.now) for one in alike.differences(then, now)]


@given(series)
def test_what_ceases_is_a_difference(then):
    late = [(at + then[-1][0] + 2 * alike.WINDOW_NS, values) for at, values in then]
    found = alike.differences([*then, *late], then)
    assert found
    assert all(math.isnan(one.now) for one in found)


def test_numbers_have_names_and_what_only_counts_is_left_out():
    message = {
        "goals": [{"id": 3, "position_rad": 0.5}, {"id": 1, "torque": 0}],
        "lease": "abc",
        "halt": 7,
        "lost": False,
    }
    assert alike.numbers(message) == {
        "goals.3.position_rad": 0.5,
        "goals.1.torque": 0.0,
        "lost": 0.0,
    }


def test_each_thing_that_happened_is_met_once():
    then = [CodedEvent(10, "drive", "stopped", "stopped"), CodedEvent(20, "drive", "stopped", "stopped")]
    now = [CodedEvent(15, "drive", "stopped", "stopped"), CodedEvent(16, "drive", "fault", "not_followed")]
    missing, new = alike.unmatched(then, now, 100)
    assert [one.kind for one in missing] == ["stopped"]
    assert [one.kind for one in new] == ["fault"]
