"""Sensors by rows: what a scan or a distance shows in the way of a motion, and that not knowing it stops the base."""

from math import atan2, cos, hypot, inf, isnan, nan, pi, sin

import msgspec
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from lbr.bus.codec import Decoder
from lbr.errors import MalformedError
from lbr.messages.sensing import RangeSensor, Scan, ranges, readings, ring
from lbr.operations.drive import sensors as sensing
from lbr.operations.drive.kernel import drive_state, first_state
from lbr.operations.drive.sensors import ASIDE_M, scanned, sensors_of
from lbr.operations.drive.settings import DriveSettings, Rule
from lbr.operations.drive.state import RangesSeen, ScanSeen
from tests.operations.drive.drive_bench import Bench

SIDES = {"forward": 0.0, "left": pi / 2, "back": pi, "right": -pi / 2}
LENGTH_M, WIDTH_M = 0.43, 0.30
RING = ring(LENGTH_M, WIDTH_M)
LIDAR = RangeSensor(name="lidar", kind="lidar", z_m=0.2, fov_rad=6.2832, min_m=0.02, max_m=12.0, rays=360)
ALONE = DriveSettings(rules=())

places = st.tuples(st.floats(-0.2, 0.2), st.floats(-0.14, 0.14), st.floats(-pi, pi))


def scan(row=LIDAR, metres=None, **fields):
    """A scan of a row; `metres` by the angle on the base."""
    values = [2.0 if metres is None else metres(angle + row.yaw_rad) for angle in row.angles()]
    given = {
        "sensor": row.name,
        "angle_min_rad": row.first_rad,
        "angle_increment_rad": row.step_rad,
        "range_min_m": row.min_m,
        "range_max_m": row.max_m,
        "ranges_m": readings(values),
    }
    return Scan(**given | fields)


def around(angle):
    """An angle between -pi and pi."""
    return (angle + pi) % (2 * pi) - pi


def room(points, row=LIDAR):
    """What a scanner sees of posts of one ray's width in an empty room of ten metres."""
    by_ray = {}
    for x_m, y_m in points:
        dx, dy = x_m - row.x_m, y_m - row.y_m
        number = round(((atan2(dy, dx) - row.yaw_rad - row.first_rad) % (2 * pi)) / row.step_rad) % row.rays
        by_ray[number] = min(by_ray.get(number, inf), hypot(dx, dy))
    return scan(row, ranges_m=readings([by_ray.get(number, 10.0) for number in range(row.rays)]))


# The messages.

numbers = st.one_of(st.floats(0.02, 12.0), st.sampled_from([inf, -inf, nan]))


@given(st.lists(numbers, max_size=50))
def test_a_scan_comes_back_from_the_bus_as_it_was(values):
    sent = scan(ranges_m=readings(values))
    back = Decoder(Scan).decode(msgspec.json.encode(sent))
    assert back == sent
    assert all(a == b or (isnan(a) and isnan(b)) for a, b in zip(back.metres(), values, strict=True))


@given(st.lists(st.floats(allow_nan=True), max_size=20))
def test_what_is_beyond_a_scanners_own_limits_is_not_known(values):
    found = scan(ranges_m=tuple(values)).metres()
    assert all(isnan(metres) or 0.02 <= metres <= 12.0 for metres in found)


@pytest.mark.parametrize(
    "text", [b'{"ranges_m": [NaN]}', b'{"ranges_m": ["near"]}', b'{"ranges_m": [1e999]}', b'{"ranges_m": 1}', b"[]"]
)
def test_rubbish_is_no_scan(text):
    whole = msgspec.json.decode(msgspec.json.encode(scan()))
    changed = msgspec.json.encode(whole | {"ranges_m": "?"}).replace(b'"ranges_m":"?"', text.strip(b"{}"))
    with pytest.raises(MalformedError):
        Decoder(Scan).decode(changed if text.startswith(b"{") else text)


names = st.from_regex("[a-z][a-z0-9_]{0,9}", fullmatch=True)
distances = st.one_of(st.none(), st.floats(0.0, 8.0))


@given(st.dictionaries(names, distances, max_size=8))
def test_ranges_of_any_name_come_back_and_keep_the_five_fields(metres):
    status = {name: "ok" if value is not None else "invalid" for name, value in metres.items()}
    data = msgspec.json.encode(ranges(metres, status))
    back = Decoder(type(ranges({}, {}))).decode(data)
    assert {name: back.metres(name) for name in metres} == metres
    assert all(back.tells_of(name) for name in metres)
    assert {"forward_m", "back_m", "left_m", "right_m", "bottom_m", "status"} <= msgspec.json.decode(data).keys()


def test_a_message_of_other_sensors_says_nothing_of_the_ring():
    assert not ranges({"bow": 1.0}, {}).tells_of("forward")
    assert ranges({"bow": 1.0, "forward": None}, {"forward": "invalid"}).tells_of("forward")
    assert ranges({}, {}).tells_of("forward")


# The geometry.


@given(st.lists(st.tuples(st.floats(-3, 3), st.floats(-3, 3)), max_size=6), places)
def test_a_scan_shows_the_nearest_of_what_is_in_the_way_on_each_side(points, place):
    row = msgspec.structs.replace(LIDAR, x_m=place[0], y_m=place[1], yaw_rad=place[2])
    points = [p for p in points if abs(p[0]) > LENGTH_M / 2 + 0.02 or abs(p[1]) > WIDTH_M / 2 + 0.02]
    seen = room(points, row)
    posts = [  # where rays say that they are: up to half a ray beside the points
        (row.x_m + m * cos(row.yaw_rad + a), row.y_m + m * sin(row.yaw_rad + a))
        for a, m in zip(row.angles(), seen.metres(), strict=True)
    ]
    found = scanned(sensors_of(ALONE, [row]), row, seen)
    for side, looks in SIDES.items():
        half_m, wide_m = (LENGTH_M / 2, WIDTH_M / 2) if side in {"forward", "back"} else (WIDTH_M / 2, LENGTH_M / 2)
        turned = [(x * cos(looks) + y * sin(looks), y * cos(looks) - x * sin(looks)) for x, y in posts]
        assume(not any(abs(abs(v) - wide_m - ASIDE_M) < 0.005 or abs(u - half_m) < 0.005 for u, v in turned))
        in_the_way = [u - half_m for u, v in turned if u > half_m and abs(v) <= wide_m + ASIDE_M]
        assert found[side] == (pytest.approx(min(in_the_way, default=inf)), "")


@given(st.floats(-pi, pi), st.floats(0.12, 1.0), places)
def test_a_part_of_a_scan_that_is_not_known_hides_what_is_in_the_way(middle, wide, place):
    row = msgspec.structs.replace(LIDAR, x_m=place[0], y_m=place[1], yaw_rad=place[2])
    blind = scan(row, lambda angle: nan if abs(around(angle - middle)) < wide / 2 else 10.0)
    far = (row.x_m + cos(middle), row.y_m + sin(middle))
    for side, looks in SIDES.items():
        half_m, wide_m = (LENGTH_M / 2, WIDTH_M / 2) if side in {"forward", "back"} else (WIDTH_M / 2, LENGTH_M / 2)
        u, v = far[0] * cos(looks) + far[1] * sin(looks), far[1] * cos(looks) - far[0] * sin(looks)
        if u > half_m + 0.1 and abs(v) < wide_m:
            assert scanned(sensors_of(ALONE, [row]), row, blind)[side] == (pytest.approx(nan, nan_ok=True), "missing")


@pytest.mark.parametrize(
    ("post", "ways"),
    [
        ((0.5, 0.0), {"forward"}),
        ((0.5, 0.14), {"forward"}),
        ((0.5, -0.25), set()),
        ((-0.5, 0.1), {"back"}),
        ((0.1, 0.5), {"left"}),
        ((0.32, 0.5), set()),
        ((-0.1, -0.5), {"right"}),
        ((-0.32, -0.5), set()),
    ],
)
def test_a_post_is_in_the_way_of_the_sides_whose_lane_it_stands_in(post, ways):
    found = scanned(sensors_of(ALONE, [LIDAR]), LIDAR, room([post]))
    assert {side for side, (metres, _) in found.items() if metres < 1.0} == ways


@pytest.mark.parametrize(("wide", "seen"), [(0.02, (inf, "")), (0.3, (nan, "missing"))])
def test_what_a_scan_sees_of_the_base_itself_is_no_obstacle_and_hides_what_is_behind_it(wide, seen):
    pole = scan(LIDAR, lambda angle: 0.05 if abs(around(angle)) < wide else 10.0)
    assert scanned(sensors_of(ALONE, [LIDAR]), LIDAR, pole)["forward"] == (pytest.approx(seen[0], nan_ok=True), seen[1])


@given(st.floats(-pi, pi))
def test_a_ray_or_two_that_are_not_known_hide_nothing(middle):
    holes = scan(LIDAR, lambda angle: nan if abs(around(angle - middle)) < 0.02 else 10.0)
    assert {trouble for _, trouble in scanned(sensors_of(ALONE, [LIDAR]), LIDAR, holes).values()} == {""}


@given(st.floats(-0.6, 0.6), st.floats(0.05, 3.0), st.floats(-1.0, 1.0))
def test_a_single_distance_is_never_taken_for_more_than_it_may_be(yaw, raw_m, across):
    """Whatever in the cone it comes from: what is in the way there is not nearer than it is taken to be."""
    row = RangeSensor(name="bow", kind="ultrasonic", x_m=LENGTH_M / 2, y_m=0.05, yaw_rad=yaw, fov_rad=0.4, max_m=8.0)
    angle = yaw + across * row.fov_rad / 2
    x_m, y_m = row.x_m + raw_m * cos(angle), row.y_m + raw_m * sin(angle)
    way = sensors_of(ALONE, [row]).ways["bow"]["forward"]
    if abs(y_m) <= WIDTH_M / 2 - 0.03:
        assert sensing.single(way, raw_m) <= x_m - LENGTH_M / 2 + 0.03


def test_rows_of_the_ring_make_no_rules_beside_the_drives_own():
    assert sensors_of(DriveSettings(), RING).rules == DriveSettings().rules
    assert sensors_of(DriveSettings(), RING).singles == ("forward", "back", "left", "right", "bottom")


def test_a_sensor_makes_rules_for_the_sides_that_it_can_see():
    made = {
        "lidar": ("forward", "back", "left", "right"),
        "bow": ("forward",),
        "flank": ("left",),
        "floor": (),
        "mute": (),
    }
    rows = [
        LIDAR,
        RangeSensor(name="bow", kind="infrared", x_m=0.215),
        RangeSensor(name="flank", kind="infrared", y_m=0.15, yaw_rad=pi / 2),
        RangeSensor(name="floor", kind="infrared", x_m=0.215, pitch_rad=1.2),
        RangeSensor(name="mute", kind="infrared", x_m=0.215, stop_m=None),
    ]
    rules = sensors_of(ALONE, rows).rules
    assert {(rule.sensor, rule.direction) for rule in rules} == {
        (f"{n} {s}", s) for n, sides in made.items() for s in sides
    }
    assert {rule.stop_m for rule in rules} == {0.25}


# The base.


class Base(Bench):
    """A bench whose base has these sensors; `scan` is what comes ten times a second, if anything does."""

    def __init__(self, *rows, scan=None, **settings):
        self.scan, self.jitter = scan, 0
        super().__init__(**settings)
        self.state = first_state(DriveSettings(**settings), sensors=rows)
        self.sense()

    def sense(self):
        super().sense()
        if self.scan is not None:
            self.jitter += 1
            values = tuple(m + 0.001 * (self.jitter % 3) if isinstance(m, float) else m for m in self.scan.ranges_m)
            self.see(msgspec.structs.replace(self.scan, ranges_m=values))

    def see(self, message):
        self.event(ScanSeen(scan=message, arrived=self.now))


def wall(side, away_m, row=LIDAR):
    """A scan of one wall, so far from the outline."""
    looks, half_m = SIDES[side], (LENGTH_M if side in {"forward", "back"} else WIDTH_M) / 2

    def metres(angle):
        ahead = cos(angle - looks)
        return min(10.0, (half_m + away_m) / ahead) if ahead > 1e-6 else 10.0

    return scan(row, metres)


MOTIONS = {"forward": 0.0, "back": 180.0, "left": -60.0, "right": 60.0}


@pytest.mark.parametrize("side", MOTIONS)
def test_what_only_the_lidar_sees_refuses_a_motion_towards_it_alone(side):
    base = Base(*RING, LIDAR, scan=wall(side, 0.15), memory_s=0.0)
    reply = base.drive(0.3, MOTIONS[side])
    assert (reply.accepted, reply.code) == (False, "obstacle")
    assert reply.reason.startswith(f"lidar {side} 0.15 m is inside 0.25 m")
    other = {"forward": "back", "back": "forward", "left": "right", "right": "left"}[side]
    assert base.drive(0.3, MOTIONS[other]).accepted


def test_the_lidar_stops_a_base_that_comes_near_and_slows_it_before():
    base = Base(*RING, LIDAR, scan=wall("forward", 3.0))
    base.drive(0.8)
    speeds = []
    for step in range(200):
        base.scan = wall("forward", max(0.1, 3.0 - 0.015 * step))
        base.now += 0.02
        base.sense()
        base.drive(0.8, lease=base.replies[0].lease)
        base.event_tick()
        speeds.append(base.setpoints[-1].left)
    assert max(speeds) == pytest.approx(0.8)
    assert speeds[-1] == 0.0
    assert any(0.0 < speed < 0.5 for speed in speeds[speeds.index(max(speeds)) :])


@pytest.mark.parametrize(
    ("message", "says"),
    [
        (None, "lidar forward was never measured"),
        (scan(metres=lambda angle: nan), "lidar forward reading is missing"),
        (scan(ranges_m=()), "lidar forward reading is not plausible"),
        (scan(angle_increment_rad=0.0), "lidar forward reading is not plausible"),
        (scan(angle_increment_rad=1.0), "lidar forward reading is not plausible"),
        (scan(range_min_m=5.0, range_max_m=1.0), "lidar forward reading is not plausible"),
        (scan(range_max_m=1.0), "lidar forward reading is missing"),
        (scan(angle_min_rad=0.5, ranges_m=(2.0,) * 90), "lidar forward reading is missing"),
        (scan(sensor="other"), "lidar forward was never measured"),
        (scan(range_min_m=0.0), ""),
    ],
)
def test_without_a_scan_to_go_by_nothing_moves(message, says):
    base = Base(*RING, LIDAR, scan=None)
    if message is not None:
        base.see(message)
    reply = base.drive(0.3)
    assert (reply.accepted, reply.code, reply.reason) == (not says, "stale_sensor" if says else "", says)


def test_a_lidar_that_falls_silent_stops_the_base_as_an_old_sensor_does():
    base = Base(*RING, LIDAR, scan=scan())
    lease = base.drive(0.3).lease
    base.scan = None
    stopped_after_s = None
    for step in range(40):
        base.now += 0.02
        base.sense()
        base.drive(0.3, lease=lease)
        base.event_tick()
        if stopped_after_s is None and step > 5 and base.setpoints[-1].left == 0.0:
            stopped_after_s = (step + 1) * 0.02
    assert stopped_after_s == pytest.approx(0.32, abs=0.021)
    assert drive_state(base.state, base.now).limited_by.startswith("lidar forward reading is older than 0.3 s")


@pytest.mark.parametrize(("metres", "changes"), [(2.0, False), (inf, False), (2.0, True)])
def test_a_lidar_that_tells_the_same_for_ever_stops_the_base_unless_anything_changes(metres, changes):
    base = Base(*RING, LIDAR)
    same = scan(metres=lambda angle: metres)
    for count in range(40):
        base.now += 0.02
        base.sense()
        behind_m = 3.0 + 0.01 * (count % 2) * changes
        base.see(msgspec.structs.replace(same, ranges_m=(behind_m, *same.ranges_m[1:])))
        base.drive(0.3, lease=base.replies[0].lease if count else "")
        base.event_tick()
    reason = drive_state(base.state, base.now).reason
    assert ("frozen" in reason, "inf" in reason, base.setpoints[-1].left == 0.0) == (not changes, False, not changes)
    base.stop()
    base.now += 0.02
    base.sense()
    base.see(same)
    assert base.drive(0.3, 90.0).accepted, "a way straight ahead changes nothing beside it"


def test_a_rule_of_the_drive_may_name_the_lidar_and_take_the_place_of_the_rows_own():
    rule = Rule(direction="forward", sensor="lidar", stop_m=0.6)
    base = Base(LIDAR, scan=wall("forward", 0.5), rules=(rule,))
    assert base.drive(0.3).reason.startswith("lidar forward 0.50 m is inside 0.60 m")
    base = Base(msgspec.structs.replace(LIDAR, stop_m=None), scan=wall("back", 0.1), rules=(rule,))
    assert base.drive(0.3, 180.0).accepted


def test_one_more_distance_counts_by_its_row():
    bow = RangeSensor(name="bow", kind="infrared", x_m=0.215, y_m=0.1, fov_rad=0.1, max_m=4.0, stop_m=0.4)
    base = Base(*RING, bow)
    assert base.drive(0.3).reason == "bow forward was never measured"
    base.event(_told(base, bow=0.35))
    assert base.drive(0.3).reason.startswith("bow forward 0.35 m is inside 0.40 m")
    base.event(_told(base, bow=5.0))
    assert base.drive(0.3).reason == "bow forward reading is implausible (5.0 m)"
    base.event(_told(base, bow=3.0))
    assert base.drive(0.3).accepted
    base.stop()
    for bow_m, sees in ((3.0, 2.996), (5.0, None)):
        base.now += 0.1
        base.event(_told(base, bow=bow_m))
        assert drive_state(base.state, base.now).sees == {"bow forward": sees}
    base.event(RangesSeen(ranges=ranges({"bow": None}, {"bow": "over_range"}), arrived=base.now))
    assert drive_state(base.state, base.now).sees == {}
    base.see(scan(bow, ranges_m=(0.1,)))
    assert base.state.memory.spots == (), "of one distance a scan says nothing"


def test_one_more_distance_that_stays_the_same_stops_the_base():
    bow = RangeSensor(name="bow", kind="infrared", x_m=0.215, fov_rad=0.1, max_m=4.0)
    base = Base(*RING, bow)
    for count in range(40):
        base.now += 0.02
        base.sense()
        base.event(_told(base, bow=2.0))
        base.drive(0.3, lease=base.replies[0].lease if count else "")
        base.event_tick()
    assert (base.setpoints[-1].left, "frozen" in drive_state(base.state, base.now).reason) == (0.0, True)


def test_a_move_may_be_bound_to_any_single_distance_and_to_no_scan():
    bow = RangeSensor(name="bow", kind="infrared", x_m=0.215, fov_rad=0.1)
    base = Base(*RING, bow, LIDAR, scan=scan())
    base.event(_told(base, bow=3.0))
    refused = base.drive(0.3, range_cm=410, sensor="bow")
    assert (refused.code, refused.reason) == ("bad_value", "range_cm 410 is outside 2 to 400")
    assert base.drive(0.3, range_cm=50, sensor="bow").accepted
    base.event(_told(base, bow=3.0))
    refused = base.drive(0.3, range_cm=50, sensor="lidar", take_over=True)
    assert refused.code == "unknown_name"
    assert refused.reason == "sensor 'lidar' is not one of forward, back, left, right, bottom, bow"


def test_a_base_without_a_sensor_called_forward_drives_all_the_same():
    base = Base(LIDAR, scan=scan(), rules=())
    assert base.drive(0.3).accepted
    assert base.drive(0.3, range_cm=0.5, take_over=True).code == "unknown_name"


def _told(base, **metres):
    return RangesSeen(ranges=ranges(metres, dict.fromkeys(metres, "ok")), arrived=base.now)


# The memory.


def test_a_scan_is_remembered_for_arcs_until_it_looks_past():
    base = Base(*RING, LIDAR, scan=room([(0.3, 0.22)]))
    assert [(round(s.x_m, 2), round(s.y_m, 2)) for s in base.state.memory.spots] == [(0.3, 0.22)]
    base.scan = scan(metres=lambda angle: 0.371 if abs(around(angle - 0.633)) < 0.02 else nan)
    base.sense()
    assert len(base.state.memory.spots) >= 1
    base.scan = room([])
    base.sense()
    assert base.state.memory.spots == ()


@pytest.mark.parametrize("place", [{"x_m": 0.1}, {"y_m": 0.08}, {"y_m": -0.08}])
def test_a_spot_is_forgotten_by_the_ray_that_goes_past_it_from_wherever_the_scanner_is(place):
    row = msgspec.structs.replace(LIDAR, **place)
    base = Base(*RING, row, scan=room([(0.3, 0.22)], row))
    spot_rad = atan2(0.22 - row.y_m, 0.3 - row.x_m)
    towards = [abs(around(angle + row.yaw_rad - spot_rad)) < 0.02 for angle in row.angles()]
    base.scan = scan(row, ranges_m=readings([nan if each else 10.0 for each in towards]))
    base.sense()
    assert base.state.memory.spots
    base.scan = scan(row, ranges_m=readings([10.0 if each else nan for each in towards]))
    base.sense()
    assert base.state.memory.spots == ()


def test_of_a_scan_what_stands_in_each_direction_is_remembered():
    places = [(0.3, 0.22), (-0.3, 0.22), (0.6, -0.22)]
    base = Base(*RING, LIDAR, scan=room(places))
    found = [(round(spot.x_m, 1), round(spot.y_m, 1)) for spot in base.state.memory.spots]
    assert sorted(found) == sorted((round(x_m, 1), round(y_m, 1)) for x_m, y_m in places)


def test_a_sensor_at_another_height_does_not_clear_what_the_lidar_saw():
    base = Base(*RING, LIDAR, scan=room([(0.5, 0.0)]))
    assert base.state.memory.spots
    base.scan = None
    for _ in range(3):
        base.now += 0.1
        base.sense()
    assert base.state.memory.spots


def test_a_scanner_does_not_clear_what_another_saw():
    other = msgspec.structs.replace(LIDAR, name="other")
    base = Base(*RING, LIDAR, other, scan=room([(0.5, 0.0)]))
    known = base.state.memory.spots
    base.see(room([], other))
    assert known
    assert base.state.memory.spots == known


@pytest.mark.parametrize(("fields", "settings"), [({"angle_increment_rad": 1.0}, {}), ({}, {"memory_s": 0.0})])
def test_a_scan_that_cannot_be_so_is_not_remembered_nor_is_any_without_a_memory(fields, settings):
    message = msgspec.structs.replace(room([(0.3, 0.22)]), **fields)
    assert Base(*RING, LIDAR, scan=message, **settings).state.memory.spots == ()
