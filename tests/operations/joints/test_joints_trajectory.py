"""Ways through key frames: they go where they should, stay between what they connect, and are never too fast."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.operations.joints import trajectory
from lbr.operations.joints.trajectory import plan, positions, speeds
from tests.operations.joints.joints_bench import frame

angles = st.floats(-3.0, 3.0)
pose = st.fixed_dictionaries({"a": angles, "b": angles})
frames = st.lists(
    st.builds(
        lambda joints, duration_s: frame(duration_s, **joints), st.one_of(pose, st.just({})), st.floats(0.02, 5.0)
    ),
    min_size=1,
    max_size=6,
).filter(lambda found: any(each.positions for each in found))
ways = st.builds(
    plan,
    pose,
    frames,
    st.fixed_dictionaries({"a": st.floats(0.1, 5.0), "b": st.floats(0.1, 5.0)}),
    st.sampled_from(["smooth", "linear"]),
    st.none() | pose,
)
LIMITS = {"a": 2.0, "b": 2.0}


@given(ways)
def test_it_passes_through_every_key_frame_exactly(way):
    for at, time_s in enumerate(way.times_s):
        found = positions(way, time_s)
        assert found == pytest.approx({name: values[at] for name, values in way.knots.items()}, abs=1e-9)
    assert positions(way, way.duration_s) == way.targets == positions(way, way.duration_s + 9.0)


@given(ways, st.lists(st.floats(0.0, 1.0), min_size=1, max_size=20))
def test_it_stays_between_neighbouring_key_frames(way, shares):
    for at, (begin_s, end_s) in enumerate(pairwise(way.times_s)):
        for share in shares:
            found = positions(way, begin_s + share * (end_s - begin_s))
            for name, values in way.knots.items():
                low, high = sorted(values[at : at + 2])
                assert low - 1e-9 <= found[name] <= high + 1e-9


@given(pose, frames, st.floats(0.1, 5.0), st.sampled_from(["smooth", "linear"]), st.none() | pose)
def test_no_joint_is_ever_faster_than_its_limit(start, through, limit_rps, how, begun):
    begun = begun and {name: max(-limit_rps, min(limit_rps, speed)) for name, speed in begun.items()}
    way = plan(start, through, {"a": limit_rps, "b": 3.0}, how, begun)
    times_s = [way.duration_s * at / 200 for at in range(201)]
    assert max(abs(speeds(way, time_s)["a"]) for time_s in times_s) <= limit_rps * (1 + 1e-6)
    for before_s, after_s in pairwise(times_s):
        gone = abs(positions(way, after_s)["a"] - positions(way, before_s)["a"])
        assert gone <= limit_rps * (after_s - before_s) + 1e-9


@given(pose, frames, st.floats(0.1, 5.0), st.sampled_from(["smooth", "linear"]))
def test_it_is_no_slower_than_its_limits_demand(start, through, limit_rps, how):
    way = plan(start, through, {"a": limit_rps, "b": limit_rps}, how)
    steps = [(begin_s, (end_s - begin_s) / 50) for begin_s, end_s in pairwise(way.times_s)]
    fastest = max(
        abs(speed) for begin_s, by_s in steps for at in range(51) for speed in speeds(way, begin_s + at * by_s).values()
    )
    assert way.stretch == 1.0 or fastest == pytest.approx(limit_rps, rel=0.01)


def test_a_way_whose_speed_rises_almost_evenly_counts_as_no_faster_than_it_is():
    assert plan({"a": 0.0}, [frame(1.0, a=1.501), frame(1.0, a=4.5)], {"a": 5.0}, "smooth", {"a": 1.0}).stretch == 1.0


@given(pose, frames, st.none() | pose)
def test_a_smooth_way_has_no_jumps_in_its_speed(start, through, begun):
    way = plan(start, through, LIMITS, "smooth", begun)
    for time_s in way.times_s[1:]:
        before, after = speeds(way, time_s - 1e-9), speeds(way, time_s + 1e-9)
        assert before == pytest.approx(after, abs=1e-3)


def test_a_smooth_way_does_not_stop_at_a_frame_it_passes_and_does_where_it_turns():
    way = plan({"a": 0.0}, [frame(1.0, a=0.5), frame(1.0, a=1.0), frame(1.0, a=0.0)], LIMITS)
    assert speeds(way, 1.0)["a"] > 0.4
    assert speeds(way, 2.0)["a"] == 0.0
    assert speeds(way, -0.1) == speeds(way, 3.0) == {"a": 0.0}
    assert (way.stretch, way.slowest) == (1.0, "")


@pytest.mark.parametrize("back", [False, True])
def test_the_speed_at_a_frame_is_the_harmonic_mean_of_both_ways_the_nearer_one_counting_for_more(back):
    knots, steps_s = [0.0, 0.2, 1.0], [1.0, 2.0]
    if back:
        knots, steps_s = knots[::-1], steps_s[::-1]
    way = plan(
        {"a": knots[0]}, [frame(step_s, a=knot) for knot, step_s in zip(knots[1:], steps_s, strict=True)], LIMITS
    )
    assert abs(speeds(way, steps_s[0])["a"]) == pytest.approx(3.0 * 3.0 / (5.0 / 0.2 + 4.0 / 0.4))


def test_all_of_it_takes_longer_when_one_joint_would_be_too_fast():
    way = plan({"a": 0.0, "b": 0.0}, [frame(1.0, a=1.0), frame(0.5, b=4.0)], LIMITS, "linear")
    assert way.times_s == pytest.approx((0.0, 4.0, 6.0))
    assert (way.stretch, way.slowest) == (pytest.approx(4.0), "b")


def test_it_goes_on_as_fast_as_the_joint_goes_already():
    way = plan({"a": 0.0}, [frame(1.0, a=1.0)], LIMITS, "smooth", {"a": 1.3})
    assert speeds(way, 0.0)["a"] == pytest.approx(1.3)
    against = plan({"a": 0.0}, [frame(1.0, a=1.0)], LIMITS, "smooth", {"a": -1.3})
    assert speeds(against, 0.0)["a"] == 0.0


def test_it_begins_slower_than_the_joint_goes_where_the_way_would_lead_beyond_its_end():
    way = plan({"a": 0.0}, [frame(1.0, a=0.4)], LIMITS, "smooth", {"a": 1.9})
    assert speeds(way, 0.0)["a"] == pytest.approx(3.0 * 0.4)


def test_a_joint_that_is_left_out_stays_and_one_that_is_never_named_is_none_of_it():
    way = plan({"a": 0.0, "b": 1.0, "c": 2.0}, [frame(1.0, a=1.0), frame(1.0, b=0.5)], LIMITS, "linear")
    assert positions(way, 1.5) == pytest.approx({"a": 1.0, "b": 0.75})


def test_what_lies_ahead_goes_on_where_it_was():
    way = plan({"a": 0.0}, [frame(1.0, a=0.5), frame(1.0, a=1.0)], LIMITS, "linear")
    assert [trajectory.passed(way, time_s) for time_s in (0.0, 0.9, 1.0, 1.9, 2.0)] == [0, 0, 1, 1, 2]
    (left,) = trajectory.ahead(way, 1.25)
    assert (left.positions, left.duration_s) == ({"a": 1.0}, 0.75)
    assert trajectory.ahead(way, 2.0) == ()
