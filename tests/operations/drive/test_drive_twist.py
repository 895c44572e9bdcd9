"""Moving by a twist: bases of any wheels, limits that keep the path's form, leases and stops as for all that moves."""

from math import inf, isclose, nan, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand, TwistCommand
from lbr.messages.kinematics import Kinematics, Wheel, base_of
from lbr.operations.drive import command, obstacle_memory
from lbr.operations.drive.kernel import drive_state, first_state
from lbr.operations.drive.settings import DriveSettings
from lbr.operations.drive.wheels import setpoint_of
from tests.operations.drive.drive_bench import Bench


def four(kind, roller=0.0):
    wheels = [
        Wheel(
            name=f"{place}_{side}",
            motor=f"{place}_{side}",
            x_m=x,
            y_m=y,
            roller_rad=-roller if x * y > 0 else roller,
            diameter_m=0.1,
        )
        for place, x in (("front", 0.2), ("rear", -0.2))
        for side, y in (("left", 0.15), ("right", -0.15))
    ]
    return base_of([Kinematics(name="base", kind=kind)], wheels, 0.27)


BASES = {"mecanum": four("mecanum", pi / 4), "skid": four("skid")}


def bench(kind=None, **settings):
    found = Bench(**settings)
    if kind:
        found.state = first_state(DriveSettings(**settings), base=BASES[kind])
        found.sense()
    return found


def move(bench, vx=0.0, vy=0.0, wz=0.0, **more):
    return bench.send(TwistCommand(vx_mps=vx, vy_mps=vy, wz_rps=wz, **more))


def keep(bench, reply, seconds, **twist):
    bench.run(seconds, renew=lambda: move(bench, **twist, lease=reply.lease))


def motors(bench):
    return bench.setpoints[-1].motors


def test_a_twist_drives_the_two_wheels_along_its_arc():
    base = bench(max_speed_mps=2.0)
    reply = move(base, vx=0.4, wz=1.0)
    assert (reply.accepted, reply.reason) == (True, "")
    keep(base, reply, 1.0, vx=0.4, wz=1.0)
    assert base.wheels == pytest.approx((0.2 - 0.0675, 0.2 + 0.0675))
    assert base.setpoints[-1].motors == {}
    assert base.setpoints[-1].lease == reply.lease


def test_a_base_that_cannot_move_sideways_says_so():
    for kind in (None, "skid"):
        reply = move(bench(kind), vy=0.2)
        assert (reply.accepted, reply.code) == (False, "bad_value")
        assert "cannot move sideways" in reply.reason


def test_mecanum_wheels_take_the_base_sideways():
    base = bench("mecanum", max_speed_mps=0.5)
    reply = move(base, vy=0.2)
    assert reply.accepted, reply
    keep(base, reply, 1.0, vy=0.2)
    assert motors(base) == pytest.approx({"front_left": -0.4, "front_right": 0.4, "rear_left": 0.4, "rear_right": -0.4})
    told = drive_state(base.state, base.now)
    assert (told.moving, told.power, told.aside, told.angle_deg) == (True, 0.4, 0.4, -90.0)


def test_power_and_angle_reach_every_motor_of_a_side():
    base = bench("skid")
    assert base.state.settings.track_m == pytest.approx(0.3), "its wheels say how far apart they are"
    reply = base.drive(0.4)
    base.run(1.0, renew=lambda: base.drive(0.4, lease=reply.lease))
    assert motors(base) == pytest.approx(dict.fromkeys(BASES["skid"].motors, 0.4))
    base.stop()
    base.run(0.1)
    reply = base.drive(0.3, 90.0)
    base.run(1.0, renew=lambda: base.drive(0.3, 90.0, lease=reply.lease))
    assert motors(base) == pytest.approx({"front_left": 0.3, "front_right": -0.3, "rear_left": 0.3, "rear_right": -0.3})


def test_more_than_the_motors_may_give_is_scaled_down_as_a_whole_and_told():
    base = bench("mecanum", max_power=0.5)
    reply = move(base, vx=1.0, vy=1.0)
    assert "limited to 25% of this twist" in reply.reason
    keep(base, reply, 1.5, vx=1.0, vy=1.0)
    assert motors(base) == pytest.approx({"front_left": 0.0, "front_right": 0.5, "rear_left": 0.5, "rear_right": 0.0})


@pytest.mark.parametrize("end", ["lapse", "stop", "estop", "motors"])
def test_whatever_ends_it_all_motors_stand_and_its_lease_moves_nothing_again(end):
    base = bench("mecanum")
    reply = move(base, vy=0.5)
    keep(base, reply, 0.5, vy=0.5)
    assert any(motors(base).values())
    if end == "lapse":
        base.run(0.4)
    elif end == "stop":
        base.stop()
    elif end == "estop":
        base.estop(engaged=True)
    else:
        base.lose_motors()
    assert base.state.sides == (0.0, 0.0, 0.0)
    assert not any(motors(base).values())
    assert not move(base, vy=0.5, lease=reply.lease).accepted
    assert base.state.sides == (0.0, 0.0, 0.0)


def test_something_on_the_left_stops_a_motion_to_the_left_and_none_to_the_right():
    base = bench("mecanum")
    base.see(left=0.15)
    refused = move(base, vy=0.3)
    assert (refused.accepted, refused.code) == (False, "obstacle")
    assert move(base, vy=-0.3).accepted


def test_a_motion_to_the_side_is_slowed_down_and_stopped_by_what_comes_near():
    base = bench("mecanum")
    reply = move(base, vy=1.0)
    keep(base, reply, 0.8, vy=1.0)
    fast = base.state.aside
    base.around = type(base.around)(
        **{f"{side}_m": None for side in ("forward", "back", "right", "bottom")},
        left_m=0.35,
        status={"left": "ok", **dict.fromkeys(("forward", "back", "right", "bottom"), "over_range")},
    )
    keep(base, reply, 0.2, vy=1.0)
    assert 0.0 < base.state.aside < fast
    base.see(left=0.18)
    keep(base, reply, 0.1, vy=1.0)
    assert base.state.sides == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("spot", "aside", "free"),
    [
        ((0.0, 0.3), 0.5, False),
        ((0.25, 0.4), 0.5, False),
        ((0.0, 0.3), -0.5, True),
        ((0.5, 0.3), 0.5, True),
        ((0.0, -0.3), -0.5, False),
        ((0.0, 3.0), 0.5, True),
        ((0.0, 0.2), 0.5, False),
        ((0.0, 0.2), -0.5, True),
    ],
)
def test_what_is_remembered_beside_the_base_limits_motion_towards_it(spot, aside, free):
    memory = obstacle_memory.ObstacleMemory(spots=(obstacle_memory.Spot(*spot, 10.0),))
    found = obstacle_memory.limit(memory, DriveSettings(), (0.0, 0.0), 10.0, (), aside)
    assert (found.scale == 1.0) is free


@pytest.mark.parametrize(("spot", "free"), [((0.6, -0.2), True), ((0.5, 0.4), False)])
def test_a_motion_to_a_corner_is_limited_by_what_is_in_its_way_and_not_by_what_it_goes_past(spot, free):
    memory = obstacle_memory.ObstacleMemory(spots=(obstacle_memory.Spot(*spot, 10.0),))
    found = obstacle_memory.limit(memory, DriveSettings(), (0.5, 0.5), 10.0, (), 0.5)
    assert (found.scale == 1.0) is free


def test_a_base_that_slid_to_the_left_has_what_it_saw_there_nearer():
    memory = obstacle_memory.ObstacleMemory(spots=(obstacle_memory.Spot(0.0, 0.6, 10.0),))
    moved = obstacle_memory.moved(memory, 0.0, 0.0, 0.5, DriveSettings(), 0.4)
    (spot,) = obstacle_memory.around(moved)
    assert (spot.x_m, spot.y_m) == pytest.approx((0.0, 0.4))


@pytest.mark.parametrize("bad", [nan, inf, -inf])
def test_a_twist_that_is_no_number_is_refused(bad):
    for twist in ({"vx": bad}, {"vy": bad}, {"wz": bad}):
        base = bench("mecanum")
        assert not move(base, **twist).accepted
        assert base.state.sides == (0.0, 0.0, 0.0)


def test_another_twist_or_heading_under_a_lease_takes_the_place_of_the_first():
    base = bench()
    base.look(heading_deg=0.0)
    for one, other in (
        (TwistCommand(vx_mps=0.2), TwistCommand(vx_mps=0.4)),
        (HeadingCommand(heading_deg=90.0), HeadingCommand(heading_deg=120.0)),
    ):
        base.now += 0.01
        reply = base.send(one)
        base.now += 0.01
        assert base.send(replace(other, lease=reply.lease)).accepted
        assert base.state.lease.motion.command == replace(other, lease=reply.lease)
        base.stop()


def test_nothing_of_a_motion_is_left_by_a_factor_of_zero_or_of_no_number():
    assert command.times((inf, -1.0, nan), 0.0) == command.times((1.0, 1.0, 1.0), nan) == (0.0, 0.0, 0.0)


def test_a_twist_of_zero_stops():
    base = bench()
    reply = move(base, vx=0.5)
    keep(base, reply, 0.5, vx=0.5)
    assert move(base).accepted
    assert base.wheels == (0.0, 0.0)


def test_users_checks_see_a_twist():
    settings = DriveSettings()
    twist = TwistCommand(vx_mps=0.3, wz_rps=0.5)
    told = command.check_request("page", twist, settings)
    assert told.twist is twist
    assert told.command == DriveCommand(power=told.command.power, angle_deg=0.0)


@pytest.mark.parametrize(
    ("asked", "angle_deg"),
    [
        (TurnCommand(angle_deg=-45.0), -90.0),
        (TurnCommand(angle_deg=0.0), 90.0),
        (TurnCommand(angle_deg=0.5), 90.0),
        (HeadingCommand(heading_deg=270.0), 90.0),
        (TwistCommand(wz_rps=0.5), -90.0),
        (TwistCommand(wz_rps=-0.5), 90.0),
        (TwistCommand(), 90.0),
    ],
)
def test_users_checks_see_a_turn_as_a_spin_to_its_side_and_as_it_was_asked(asked, angle_deg):
    told = command.check_request("page", asked, DriveSettings())
    assert told.command.angle_deg == angle_deg
    assert (told.turn or told.heading or told.twist) is asked


speeds = st.floats(-10.0, 10.0)


@given(st.sampled_from(["mecanum", "skid", None]), speeds, speeds, speeds, st.floats(0.1, 1.0))
def test_every_setpoint_on_the_way_to_a_twist_is_within_the_limits_and_on_its_path(kind, vx, vy, wz, max_power):
    base = bench(kind, max_power=max_power)
    vy = vy if kind == "mecanum" else 0.0
    reply = move(base, vx, vy, wz * 2)
    twist = {"vx": vx, "vy": vy, "wz": wz * 2}
    if not reply.accepted:
        return
    keep(base, reply, 0.2, **twist)
    wanted = command.asked_sides(TwistCommand(vx_mps=vx, vy_mps=vy, wz_rps=wz * 2), base.state.settings)
    for setpoint in base.setpoints:
        powers = setpoint.motors.values() or (setpoint.left, setpoint.right)
        assert all(-max_power - 1e-9 <= power <= max_power + 1e-9 for power in powers)
    got, top = base.state.sides, max(map(abs, wanted))
    share = max(map(abs, got)) / top if top else 0.0
    assert all(isclose(one, other * share, abs_tol=1e-6) for one, other in zip(got, wanted, strict=True))
    assert set(setpoint_of(base.state, "").motors) == (set() if kind is None else set(base.state.base.motors))
