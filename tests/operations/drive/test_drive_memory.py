"""What was seen and lost: geometry in words, what no history can do, and somebody beside an arc."""

from math import atan2, cos, hypot, inf, isfinite, nan, pi, sin, tau

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from msgspec.structs import replace

from lbr.messages.sensing import RING as SENSORS
from lbr.messages.sensing import Ranges
from lbr.operations.drive import limits, obstacle_memory, rules
from lbr.operations.drive.footprint import Footprint
from lbr.operations.drive.heading_view import HeadingView
from lbr.operations.drive.kernel import drive_state
from lbr.operations.drive.obstacle_memory import MOST_SPOTS, ObstacleMemory, Spot, ahead, around, limit, moved, see
from lbr.operations.drive.odometry_view import OdometryView
from lbr.operations.drive.rules import MEMORY, Odometer
from lbr.operations.drive.settings import DriveSettings
from tests.models.approach import run, trials
from tests.operations.drive.drive_bench import Bench, ranges

SETTINGS = DriveSettings()
AHEAD_M, ASIDE_M = SETTINGS.body_length_m / 2, SETTINGS.body_width_m / 2
MARGIN_M = SETTINGS.memory_margin_m
AHEAD, BACK, LEFT_ARC, RIGHT_ARC, SPIN = (0.5, 0.5), (-0.5, -0.5), (0.2, 0.5), (0.5, 0.2), (0.3, -0.3)


class Watcher:
    """A base that sees and drives: its views and its memory."""

    def __init__(self, **settings):
        self.settings = DriveSettings(**settings)
        self.now = 10.0
        self.views = {}
        self.memory = ObstacleMemory()

    def see(self, times=2, **metres):
        for _ in range(times):
            self.now = round(self.now + 0.1, 6)
            self.views = rules.see(self.views, ranges(**metres), self.now, Odometer())
            self.memory = see(self.memory, self.views, self.now, self.settings)
        return self

    def drive(self, left, right, seconds):
        for _ in range(round(seconds * 50)):
            self.memory = moved(self.memory, left, right, 0.02, self.settings)
        return self

    def limit(self, wheels, blocked=()):
        return limit(self.memory, self.settings, wheels, self.now, blocked)


@pytest.fixture
def watcher():
    return Watcher()


def at(x_m, y_m):
    """A memory of one spot."""
    return ObstacleMemory(spots=(Spot(x_m, y_m, 10.0),))


# what a motion comes to


def test_what_the_side_sensor_lost_stops_an_arc_to_that_side(watcher):
    watcher.see(left=0.5).drive(0.35, 0.65, 0.8).see()
    found = watcher.limit((0.35, 0.65))
    assert found.scale < 0.7
    assert found.direction == MEMORY
    assert found.text.startswith("something remembered")


@pytest.mark.parametrize(
    ("wheels", "free"),
    [(AHEAD, True), (BACK, True), ((0.5, 0.43), True), (RIGHT_ARC, True), (LEFT_ARC, False), ((-0.3, 0.3), False)],
    ids=["ahead", "back", "a slight correction", "arc away", "arc towards it", "spin towards it"],
)
def test_only_what_sweeps_towards_it_heeds_it(wheels, free):
    beside_the_left_front_corner = at(AHEAD_M + 0.03, ASIDE_M + 0.10)
    assert (limit(beside_the_left_front_corner, SETTINGS, wheels, 10.0).scale == 1.0) is free


@pytest.mark.parametrize("wheels", [(-0.3, 0.3), (0.3, -0.3)], ids=["left", "right"])
@pytest.mark.parametrize(
    ("x_m", "y_m", "free"),
    [
        (0.33, 0.10, False),
        (0.40, 0.0, True),
        (0.0, 0.30, False),
        (0.0, 0.40, True),
        (-0.33, -0.10, False),
        (0.0, 0.0, True),
    ],
    ids=["near a front corner", "ahead", "beside, where corners come by", "beside", "near a back corner", "inside"],
)
def test_a_spin_comes_to_what_its_corners_sweep(x_m, y_m, free, wheels):
    assert (ahead(at(x_m, y_m), wheels, SETTINGS).way_m == inf) is free


def test_the_way_is_that_of_the_faster_wheel():
    """About a point 1 m to the left, the front face comes to what is level with that point on the face's circle."""
    half_m, front_m = SETTINGS.track_m / 2, AHEAD_M + MARGIN_M
    way_m = ahead(at(hypot(front_m, 1.0), 1.0), (0.5 * (1.0 - half_m), 0.5 * (1.0 + half_m)), SETTINGS).way_m
    assert way_m == pytest.approx(atan2(1.0, front_m) * (1.0 + half_m), abs=1e-6)


def test_what_is_within_the_margin_forbids_only_to_come_nearer():
    at_the_front_corner = at(AHEAD_M + 0.03, ASIDE_M - 0.01)
    nearer, away = (
        limit(at_the_front_corner, SETTINGS, (0.2, 0.5), 10.0),
        limit(at_the_front_corner, SETTINGS, (-0.2, -0.5), 10.0),
    )
    assert (nearer.scale, away.scale) == (0.0, 1.0)
    assert nearer.text == "something remembered ahead at 0.03 m"


def test_the_speed_follows_the_way_that_is_left():
    scales = [limit(at(x_m, 0.4), SETTINGS, (0.5, 1.0), 10.0).scale for x_m in (0.35, 0.45, 0.5, 0.6)]
    assert scales == sorted(scales)
    assert 0.0 < scales[1] < scales[-1]


def test_a_stop_is_held_until_there_is_some_more_way():
    spot = at(0.45, 0.4)
    way_m = ahead(spot, LEFT_ARC, SETTINGS).way_m
    settings = DriveSettings(memory_stop_m=way_m - 0.02)
    assert limit(spot, settings, LEFT_ARC, 10.0).scale > 0.0
    stopped = limit(spot, settings, LEFT_ARC, 10.0, [MEMORY])
    assert stopped.scale == 0.0
    assert stopped.blocked == (MEMORY,)


# what is remembered, and what is forgotten


def test_a_base_that_drives_straight_ahead_leaves_it_behind(watcher):
    watcher.see(left=0.4).drive(0.5, 0.5, 0.4)
    assert {round(spot.y_m, 3) for spot in around(watcher.memory)} == {0.55}
    assert max(spot.x_m for spot in around(watcher.memory)) == pytest.approx(SETTINGS.memory_aside_m - 0.2, abs=1e-3)


def test_a_quarter_turn_to_the_left_brings_what_was_left_ahead(watcher):
    watcher.see(left=0.45)
    seconds = (pi / 2) / (2 * 0.2 / SETTINGS.track_m)
    watcher.drive(-0.2, 0.2, round(seconds, 2))
    assert {round(spot.x_m, 1) for spot in around(watcher.memory)} == {0.6}


def test_the_attitude_knows_better_than_the_wheels_how_far_it_turned(watcher):
    watcher.see(left=0.45).drive(-0.2, 0.2, 0.5)
    before = HeadingView(trouble="", epoch="e", turned_deg=10.0, seen=1.0)
    right = obstacle_memory.turned(watcher.memory, before, replace(before, turned_deg=-80.0, seen=1.5))
    assert {round(spot.x_m, 6) for spot in around(right)} == {0.6}
    anew = obstacle_memory.turned(watcher.memory, before, replace(before, epoch="f", turned_deg=0.0))
    assert anew.yaw_rad == watcher.memory.yaw_rad


def test_the_odometry_knows_better_than_the_powers_how_far_it_drove(watcher):
    watcher.see(left=0.45).drive(0.5, 0.5, 1.0)
    before = OdometryView(trouble="", epoch="o", distance_m=3.0, seen=1.0)
    right = obstacle_memory.drove(watcher.memory, before, replace(before, distance_m=3.1, seen=2.0))
    assert right.x_m == pytest.approx(0.1)
    assert obstacle_memory.drove(right, before, replace(before, trouble="lost")).x_m == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("yaw_rad", "ahead_m", "aside_m", "place"),
    [
        (0.0, 0.1, 0.0, (0.9, 0.0)),
        (0.0, 0.0, 0.1, (1.0, -0.1)),
        (pi / 2, 0.1, 0.0, (-0.1, -1.0)),
        (pi / 2, 0.0, 0.1, (0.0, -1.1)),
        (-pi / 2, 0.0, 0.1, (0.0, 0.9)),
    ],
)
def test_a_base_that_has_turned_moves_ahead_and_aside_from_where_it_looks(yaw_rad, ahead_m, aside_m, place):
    memory = replace(at(1.0, 0.0), yaw_rad=yaw_rad)
    power = ahead_m / SETTINGS.max_speed_mps
    memory = moved(memory, power, power, 1.0, SETTINGS, aside_m / SETTINGS.max_speed_mps)
    (spot,) = around(memory)
    assert (spot.x_m, spot.y_m) == pytest.approx(place, abs=1e-9)


@pytest.mark.parametrize(
    ("moved_by", "stands"),
    [
        ({"x_m": 0.009}, True),
        ({"y_m": -0.009}, True),
        ({"x_m": -0.011}, False),
        ({"x_m": 0.008, "y_m": 0.008}, False),
        ({"yaw_rad": -0.009}, True),
        ({"yaw_rad": 0.011}, False),
    ],
)
def test_what_a_sensor_saw_is_its_own_until_the_base_has_moved_by_a_centimetre_or_half_a_degree(
    watcher, moved_by, stands
):
    memory = replace(watcher.see(left=0.5).memory, **moved_by)
    assert {spot.by for spot in memory.spots} == {"left"}
    after = see(memory, {}, watcher.now, watcher.settings)
    assert {spot.by for spot in after.spots} == ({"left"} if stands else {None})
    assert (after.x_m, after.y_m, after.yaw_rad) == ((memory.x_m, memory.y_m, memory.yaw_rad) if stands else (0.0,) * 3)


@pytest.mark.parametrize("side", ["left", "right", "back", "forward"])
def test_what_is_seen_again_at_the_same_place_is_remembered_once(watcher, side):
    once = len(watcher.see(**{side: 0.5}).memory.spots)
    assert once > 0
    assert len(watcher.see(5, **{side: 0.5}).memory.spots) == once


def test_it_is_forgotten_after_a_while():
    watcher = Watcher(memory_s=2.0).see(left=0.5).drive(0.5, 0.5, 1.0)
    assert watcher.see(times=15).memory.spots
    watcher.now += 1.0
    assert watcher.limit(SPIN).scale == 1.0
    assert not watcher.see().memory.spots


def test_memory_0_remembers_nothing():
    assert not Watcher(memory_s=0.0).see(left=0.5).memory.spots


def test_what_a_sensor_sees_past_from_the_same_place_is_gone_with_all_that_was_taken_to_belong_to_it(watcher):
    watcher.see(left=0.15)
    assert watcher.limit(SPIN).scale == 0.0
    assert watcher.see(times=1).memory.spots, "one reading that is so much farther proves nothing"
    assert not watcher.see(times=1).memory.spots


def test_from_another_place_only_what_is_in_its_cone_is_gone(watcher):
    watcher.see(left=0.5).drive(0.5, 0.5, 0.2)
    before, after = len(watcher.memory.spots), len(watcher.see().memory.spots)
    assert 0 < after < before


@pytest.mark.parametrize("reading", ["missing", "invalid", nan, inf, -1.0, 0.0, 99.0])
def test_no_reading_and_no_impossible_one_frees_or_adds_anything(watcher, reading):
    known = watcher.see(left=0.3).memory.spots
    assert watcher.see(left=reading).memory.spots == known


def test_a_memory_of_half_a_second_is_one_too():
    assert Watcher(memory_s=0.5).see(left=0.3).memory.spots


def test_what_is_far_away_is_not_remembered(watcher):
    assert not watcher.see(forward=1.5, left=3.0).memory.spots


def test_a_clock_that_went_back_frees_nothing():
    bench = Bench()
    bench.see(left=0.3)
    bench.around = ranges(left="missing")
    bench.now = 3.0
    bench.sense()
    assert {spot.seen for spot in bench.state.memory.spots} == {3.0}
    bench.now += SETTINGS.memory_s
    bench.sense()
    assert bench.state.memory.spots == ()


def test_what_is_remembered_goes_by_as_attitude_and_odometry_tell():
    bench = Bench()
    bench.look()
    bench.count()
    bench.see(forward=1.0)
    bench.now += 0.1
    bench.count(distance_m=0.2)
    bench.look(turned_deg=18.0)
    turned = [(hypot(spot.x_m, spot.y_m), atan2(spot.y_m, spot.x_m)) for spot in around(bench.state.memory)]
    assert min(turned) == pytest.approx((AHEAD_M + 0.8, pi / 10))


def test_what_is_seen_and_what_is_remembered_hold_a_stop_both():
    bench = Bench()
    bench.see(forward=0.2)
    state = replace(bench.state, memory=obstacle_memory.redated(at(AHEAD_M + 0.05, -0.05), bench.now))
    assert limits.limit(state, (*RIGHT_ARC, 0.0), bench.now).blocked == ("forward", MEMORY)


# who is told


def test_people_are_told_that_the_memory_slows_and_stops_the_base():
    bench = Bench()
    reply = bench.drive(0.65, -17)
    renew = lambda: bench.drive(0.65, -17, lease=reply.lease)  # noqa: E731
    bench.run(0.4, renew)
    bench.see(left=0.5)
    bench.run(0.3, renew)
    bench.see()
    bench.run(1.8, renew)
    assert bench.wheels == (0.0, 0.0)
    told = [text for text in bench.texts if text.startswith("the memory rule")]
    assert "slows" in told[0]
    assert told[-1].startswith("the memory rule stops the base: something remembered on the left at 0.")
    assert drive_state(bench.state, bench.now).reason.startswith("stopped by something remembered")


def test_a_motion_that_it_holds_still_ends():
    bench = Bench(memory_stop_m=1.0)
    reply = bench.drive(0.3, -30)
    bench.see(left=0.3)
    bench.run(1.5, lambda: bench.drive(0.3, -30, lease=reply.lease))
    assert bench.state.lease is None
    assert any("held still for 1 s: something remembered" in text for text in bench.texts)
    assert bench.drive(0.3, -30).reason.startswith("something remembered")
    assert bench.drive(0.3).accepted


# what no history and no geometry can do

place = st.floats(-1.0, 1.0)
wheel = st.floats(-1.0, 1.0)
any_reading = st.one_of(st.none(), st.floats(), st.floats(0.0, 2.0))
any_status = st.dictionaries(st.sampled_from(SENSORS), st.sampled_from(["ok", "over_range", "invalid", "missing"]))
any_ranges = st.builds(Ranges, **{f"{name}_m": any_reading for name in SENSORS}, status=any_status)
history = st.lists(st.tuples(any_ranges, wheel, wheel, st.floats(0.0, 1.0)), max_size=12)


def remembered(trace):
    views, memory, now = {}, ObstacleMemory(), 10.0
    for readings, left, right, dt_s in trace:
        now += dt_s
        memory = moved(memory, left, right, dt_s, SETTINGS)
        views = rules.see(views, readings, now, Odometer())
        memory = see(memory, views, now, SETTINGS)
    return memory


@given(history, wheel, wheel)
def test_it_only_slows_down_and_stays_small(trace, left, right):
    memory = remembered(trace)
    found = limit(memory, SETTINGS, (left, right), 10.0)
    assert isfinite(found.scale)
    assert 0.0 <= found.scale <= 1.0
    assert len(memory.spots) <= MOST_SPOTS
    assert all(isfinite(spot.x_m) and isfinite(spot.y_m) for spot in memory.spots)
    assert remembered(trace) == memory


@given(history, wheel, wheel)
def test_left_and_right_are_alike(trace, left, right):
    memory = remembered(trace)
    mirrored = replace(
        memory,
        spots=tuple(spot._replace(y_m=-spot.y_m) for spot in memory.spots),
        y_m=-memory.y_m,
        yaw_rad=-memory.yaw_rad,
    )
    assert limit(memory, SETTINGS, (left, right), 10.0).scale == pytest.approx(
        limit(mirrored, SETTINGS, (right, left), 10.0).scale, abs=1e-6
    )


@given(place, place, wheel, wheel)
def test_a_spot_more_never_frees(x_m, y_m, left, right):
    one, two = at(0.4, 0.3), ObstacleMemory(spots=(Spot(0.4, 0.3, 10.0), Spot(x_m, y_m, 10.0)))
    assert limit(two, SETTINGS, (left, right), 10.0).scale <= limit(one, SETTINGS, (left, right), 10.0).scale


def out_m(radius_m, x_m, y_m, turned_rad):
    """The distance of a point from the outline of a base that has turned so far about (0, radius_m)."""
    c, s, y = cos(turned_rad), sin(turned_rad), y_m - radius_m
    here_x, here_y = c * x_m + s * y, radius_m + c * y - s * x_m
    return hypot(max(0.0, abs(here_x) - AHEAD_M), max(0.0, abs(here_y) - ASIDE_M))


@given(st.floats(-0.8, 0.8), place, place)
@example(0.0, 0.0084, 0.269)
@example(0.0, -0.0084, -0.269)
def test_the_closed_form_is_what_small_steps_find(radius_m, x_m, y_m):
    spot = radius_m, x_m, y_m
    assume(out_m(*spot, 0.0) > MARGIN_M + 1e-6)
    found = Footprint(AHEAD_M, ASIDE_M, MARGIN_M, radius_m).until_rad(x_m, y_m)
    steps = [degree * tau / 720 for degree in range(720)]
    assert all(out_m(*spot, step) > MARGIN_M - 1e-6 for step in steps if step < found)
    if found < inf:
        assert out_m(*spot, found) == pytest.approx(MARGIN_M, abs=1e-6)


@given(
    st.floats(-0.8, 0.8),
    st.floats(-AHEAD_M - MARGIN_M, AHEAD_M + MARGIN_M),
    st.floats(-ASIDE_M - MARGIN_M, ASIDE_M + MARGIN_M),
)
def test_a_spot_within_the_margin_forbids_to_come_nearer_and_one_within_the_outline_nothing(radius_m, x_m, y_m):
    now_m, then_m = (out_m(radius_m, x_m, y_m, turned_rad) for turned_rad in (0.0, 1e-6))
    assume(now_m < MARGIN_M - 1e-6 and (now_m == 0.0 or abs(then_m - now_m) > 1e-9))
    nearer = now_m > 0.0 and then_m < now_m
    assert Footprint(AHEAD_M, ASIDE_M, MARGIN_M, radius_m).until_rad(x_m, y_m) == (0.0 if nearer else inf)


def test_a_spot_on_the_very_edge_of_the_margin_is_met_now():
    assert Footprint(0.25, 0.125, 0.125, 0.0).until_rad(0.375, -0.0625) == pytest.approx(0.0, abs=1e-6)


# in the world


@pytest.mark.parametrize("side", ["left", "right"])
def test_somebody_who_appears_beside_an_arc_is_not_run_into(side):
    drawn = list(trials(side, 6, 1))
    assert not [trial for trial in drawn if run(trial, SETTINGS).contact]
    assert any(run(trial, DriveSettings(memory_s=0.0)).contact for trial in drawn), "without the memory some are"
