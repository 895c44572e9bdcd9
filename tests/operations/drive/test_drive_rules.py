"""Range rules: a table of distances, the doubtful readings, and what no reading can do."""

from math import inf, isfinite, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.messages.sensing import RING as SENSORS
from lbr.messages.sensing import Ranges
from lbr.operations.drive.rules import FREE, Odometer, View, allowed_mps, believed, limit, measured_m, see, towards
from lbr.operations.drive.settings import DriveSettings, Rule

SETTINGS = DriveSettings()
AHEAD, BACK, SPIN = (1.0, 1.0), (-1.0, -1.0), (0.5, -0.5)
NO_MOTION = Odometer()


def ranges(**metres):
    given_m = {f"{name}_m": None for name in SENSORS}
    status = dict.fromkeys(SENSORS, "over_range")
    for name, value in metres.items():
        status[name] = value if isinstance(value, str) else "ok"
        given_m[f"{name}_m"] = None if isinstance(value, str) else value
    return Ranges(**given_m, status=status)


def views(now=10.0, odometer=NO_MOTION, before=None, **metres):
    return see(before or {}, ranges(**metres), now, odometer)


@pytest.mark.parametrize(
    ("forward_m", "scale"),
    [
        (0.10, 0.0),
        (0.25, 0.0),
        (0.26, 0.0316),
        (0.30, 0.1453),
        (0.50, 0.5250),
        (0.88, 0.9970),
        (0.89, 1.0),
        (3.0, 1.0),
        ("over_range", 1.0),
    ],
)
def test_speed_ahead_follows_the_room_there_is(forward_m, scale):
    assert limit(SETTINGS, views(forward=forward_m), AHEAD, 10.0).scale == pytest.approx(scale, abs=2e-3)


def test_a_faster_base_is_slowed_down_by_more():
    faster = DriveSettings(max_speed_mps=2.0)
    assert limit(faster, views(forward=0.5), AHEAD, 10.0).scale == pytest.approx(0.5250 / 2, abs=1e-3)


def test_an_odometer_counts_the_way_along_and_what_side_sensors_see_go_by():
    driven = Odometer(along_m=1.0, turned_m=1.0).driven(0.5, 0.3, 0.1, 2.0, aside=-0.2)
    assert (driven.along_m, driven.turned_m) == pytest.approx((1.08, 1.06))


def test_at_the_very_speed_that_it_allows_a_rule_says_nothing():
    settings = DriveSettings(reaction_s=1.0, brake_mps2=2.0)
    assert limit(settings, views(forward=1.5), AHEAD, 10.0) == FREE


@pytest.mark.parametrize("status", ["invalid", "missing"])
def test_an_invalid_or_missing_reading_is_an_obstacle(status):
    found = limit(SETTINGS, views(forward=status), AHEAD, 10.0)
    assert found.scale == 0.0
    assert status in found.text


@pytest.mark.parametrize("value", [0.0, -0.01, 8.01, nan, inf, -inf])
def test_an_impossible_reading_is_an_obstacle(value):
    assert limit(SETTINGS, views(forward=value), AHEAD, 10.0).scale == 0.0


def test_a_value_that_is_null_though_called_ok_is_an_obstacle():
    silent = Ranges(forward_m=None, back_m=None, left_m=None, right_m=None, bottom_m=None, status={"forward": "ok"})
    assert limit(SETTINGS, see({}, silent, 10.0, NO_MOTION), AHEAD, 10.0).scale == 0.0


def test_a_reading_without_status_is_taken_and_none_is_missing():
    bare = Ranges(forward_m=1.5, back_m=None, left_m=None, right_m=None, bottom_m=None, status={})
    assert measured_m(bare, "forward") == (1.5, "")
    assert measured_m(bare, "back")[1] == "missing"


def test_a_range_never_measured_is_an_obstacle():
    found = limit(SETTINGS, {}, AHEAD, 10.0)
    assert found.scale == 0.0
    assert found.text == "forward was never measured"


@pytest.mark.parametrize(("now", "scale"), [(10.29, 1.0), (10.31, 0.0), (nan, 0.0)])
def test_a_reading_older_than_its_age_limit_is_an_obstacle(now, scale):
    assert limit(SETTINGS, views(forward=3.0), AHEAD, now).scale == scale


@pytest.mark.parametrize(
    ("age_s", "idle_m", "known"), [(0.25, 0.125, True), (0.251, 0.125, False), (0.25, 0.126, False)]
)
def test_a_reading_counts_to_the_very_end_of_its_age_and_of_the_way_that_it_may_stay_the_same(age_s, idle_m, known):
    view = View(distance_m=2.0, trouble="", seen=10.0, raw_m=2.0, idle_m=idle_m, repeats=2)
    rule = Rule(direction="forward", sensor="forward", max_age_s=0.25, frozen_after_m=0.125)
    assert isfinite(believed(view, rule, 10.0 + age_s)[0]) is known


def repeated(value, odometers, sensor="forward"):
    seen = {}
    for count, odometer in enumerate(odometers):
        seen = views(now=10.0 + count * 0.1, odometer=odometer, before=seen, **{sensor: value})
    return seen, 10.0 + (len(odometers) - 1) * 0.1


def test_a_reading_that_stays_the_same_while_the_base_drives_is_frozen():
    seen, now = repeated(2.0, [Odometer(along_m=0.08 * n) for n in range(3)])
    assert "frozen at 2.00 m" in limit(SETTINGS, seen, AHEAD, now).text


def test_a_frozen_reading_is_trusted_again_once_it_changes():
    seen, now = repeated(2.0, [Odometer(along_m=0.08 * n) for n in range(3)])
    seen = views(now=now + 0.1, odometer=Odometer(along_m=0.3), before=seen, forward=1.99)
    assert limit(SETTINGS, seen, AHEAD, now + 0.1).scale == 1.0


def test_a_reading_that_comes_twice_is_not_frozen_yet_however_far_the_base_came():
    seen = {}
    for count, value in enumerate((2.0, 2.01, 2.01)):
        seen = views(now=10.0 + 0.1 * count, odometer=Odometer(along_m=0.2 * count), before=seen, forward=value)
    assert limit(SETTINGS, seen, AHEAD, 10.2).scale == 1.0


def test_a_reading_may_stay_the_same_while_the_base_stands():
    seen, now = repeated(2.0, [NO_MOTION] * 50)
    assert limit(SETTINGS, seen, AHEAD, now).scale == 1.0


def test_a_side_reading_may_stay_the_same_along_a_wall_but_not_in_a_long_turn():
    along, now = repeated(1.0, [Odometer(along_m=0.1 * n) for n in range(10)], "right")
    assert limit(SETTINGS, along, SPIN, now).scale == 1.0
    turned, now = repeated(1.0, [Odometer(turned_m=0.1 * n) for n in range(10)], "right")
    assert limit(SETTINGS, turned, SPIN, now).scale == 0.0


@pytest.mark.parametrize(("value", "counts"), [(0.83, True), (0.85, False)])
def test_a_reading_that_is_farther_than_a_base_can_have_come_does_not_count_at_once(value, counts):
    once = views(now=10.1, before=views(forward=0.24), forward=value)
    assert once["forward"].distance_m == (value if counts else 0.24)


def test_a_jump_to_far_away_counts_only_when_confirmed():
    near = views(forward=0.24)
    once = views(now=10.1, before=near, forward=4.0)
    assert limit(SETTINGS, once, AHEAD, 10.1).scale == 0.0
    twice = views(now=10.2, before=once, forward=4.02)
    assert limit(SETTINGS, twice, AHEAD, 10.2).scale == 1.0


def test_a_jump_to_over_range_counts_only_when_confirmed():
    once = views(now=10.1, before=views(forward=0.24), forward="over_range")
    assert limit(SETTINGS, once, AHEAD, 10.1).scale == 0.0
    assert limit(SETTINGS, views(now=10.2, before=once), AHEAD, 10.2).scale == 1.0


def test_something_that_appears_counts_at_once():
    assert limit(SETTINGS, views(now=10.1, before=views(forward=4.0), forward=0.2), AHEAD, 10.1).scale == 0.0


@pytest.mark.parametrize(
    ("wheels", "sides"),
    [
        (AHEAD, {"forward"}),
        (BACK, {"back"}),
        (SPIN, {"left", "right"}),
        ((-0.5, 0.5), {"left", "right"}),
        ((0.5, 0.2), {"forward", "right"}),
        ((0.2, 0.5), {"forward", "left"}),
        ((-0.5, -0.2), {"back", "right"}),
        ((-0.2, -0.5), {"back", "left"}),
        ((0.5, 0.43), {"forward"}),
        ((0.5, 0.33), {"forward", "right"}),
        ((0.5, -0.34), {"forward", "right"}),
        ((0.5, -0.36), {"forward", "left", "right"}),
        ((0.515, -0.485), {"forward", "left", "right"}),
        ((0.5, -0.485), {"left", "right"}),
        ((0.485, -0.5), {"left", "right"}),
        ((0.0, 0.0), set()),
    ],
)
def test_a_motion_looks_where_it_goes(wheels, sides):
    assert {side for side, part in towards(*wheels).items() if part > 0.0} == sides


@pytest.mark.parametrize(
    ("wheels", "free"),
    [(AHEAD, True), (BACK, True), ((0.2, 0.5), True), ((-0.2, -0.5), True), ((0.5, 0.2), False), (SPIN, False)],
    ids=["along", "back along", "curve away", "curve back away", "curve into it", "spin"],
)
def test_beside_a_wall_the_base_can_still_drive_away(wheels, free):
    beside = views(right=0.18)
    assert (limit(SETTINGS, beside, wheels, 10.0).scale == 1.0) is free


def test_motion_away_from_an_obstacle_is_free():
    assert limit(SETTINGS, views(forward=0.1), BACK, 10.0).scale == 1.0


def test_the_strictest_rule_is_named():
    found = limit(SETTINGS, views(forward=0.6, right=0.3), (0.9, 0.3), 10.0)
    assert found.direction == "right"
    assert found.text == "right 0.30 m"


def test_a_stop_is_held_until_there_is_some_margin():
    stopped = limit(SETTINGS, views(forward=0.25), AHEAD, 10.0)
    assert stopped.blocked == ("forward",)
    assert limit(SETTINGS, views(forward=0.29), AHEAD, 10.0, stopped.blocked).scale == 0.0
    assert limit(SETTINGS, views(forward=0.29), AHEAD, 10.0).scale > 0.0
    assert limit(SETTINGS, views(forward=0.33), AHEAD, 10.0, stopped.blocked).scale > 0.0


def test_a_rule_may_watch_another_sensor_or_be_left_out():
    swapped = DriveSettings(rules=(Rule(direction="forward", sensor="back", stop_m=0.5),))
    seen = views(forward=0.1, back=0.5, left=0.1)
    assert limit(swapped, seen, AHEAD, 10.0).detail == "back 0.50 m is inside 0.50 m"
    assert limit(swapped, seen, SPIN, 10.0).scale == 1.0


@given(st.floats(0.0, 10.0), st.floats(0.01, 2.0), st.floats(0.1, 20.0))
def test_from_the_allowed_speed_the_base_stops_in_the_room_there_is(room_m, reaction_s, brake_mps2):
    speed = allowed_mps(room_m, DriveSettings(reaction_s=reaction_s, brake_mps2=brake_mps2))
    assert speed * reaction_s + speed**2 / (2 * brake_mps2) == pytest.approx(room_m, abs=1e-6)


any_reading = st.one_of(st.none(), st.floats(), st.floats(0.0, 4.0))
any_status = st.dictionaries(st.sampled_from(SENSORS), st.sampled_from(["ok", "over_range", "invalid", "missing"]))
any_ranges = st.builds(
    Ranges,
    forward_m=any_reading,
    back_m=any_reading,
    left_m=any_reading,
    right_m=any_reading,
    bottom_m=any_reading,
    status=any_status,
)
wheel = st.floats(-1.0, 1.0)


@given(st.lists(st.tuples(any_ranges, st.floats(0.0, 1.0))), wheel, wheel, st.floats())
def test_no_reading_ever_makes_a_rule_raise_the_speed(trace, left, right, late_s):
    seen, now, odometer = {}, 0.0, NO_MOTION
    for readings, dt_s in trace:
        now += dt_s
        odometer = odometer.driven(left, right, dt_s, 1.0)
        seen = see(seen, readings, now, odometer)
    found = limit(SETTINGS, seen, (left, right), now + late_s)
    assert isfinite(found.scale)
    assert 0.0 <= found.scale <= 1.0
    assert all(isinstance(view, View) for view in seen.values())
