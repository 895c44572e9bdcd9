"""What is stopped in mid-step goes on to the nearest place where it stands, within its time, unless it is to hold at once."""

import pytest

from lbr.leases.lease import Stop
from lbr.messages.joints import KeyFrame, StoredMotion
from lbr.operations.joints.feet import LONGEST_S
from lbr.operations.joints.view import joints_state
from tests.operations.joints.joints_bench import DT, Bench, frame

STEP = tuple(
    KeyFrame(positions={"left_knee": -angle, "head_yaw": angle / 2}, duration_s=0.2, stable=stable)
    for angle, stable in ((0.2, True), (0.4, False), (0.6, True), (0.3, False), (0.1, False))
)


@pytest.fixture
def bench():
    return Bench().standing()


def steps(bench, frames=STEP, seconds=0.3, **more):
    """Have it come into the way to the second key frame."""
    lease = bench.command(frames=frames, **more).lease
    bench.run(seconds, lease)
    return lease


def stands(bench):
    return bench.state.feet is None and bench.state.leases.live is None


def test_a_stop_goes_on_to_the_next_stable_frame_and_says_so(bench):
    steps(bench)
    reply = bench.stop()
    assert (reply.accepted, reply.code) == (True, "to_feet")
    assert "within 0.4 s" in reply.reason
    assert (bench.results[-1].result, bench.results[-1].code) == ("stopped", "stopped")
    assert bench.setpoint.lease, "a driver that ended it does not take it up again"
    bench.run(0.1)
    left_s = joints_state(bench.state, bench.now).feet_s
    bench.run(0.1)
    assert joints_state(bench.state, bench.now).feet_s == pytest.approx(left_s - 0.1, abs=0.015)
    bench.run(0.2)
    assert bench.goals["left_knee"] == pytest.approx(-0.6)
    assert bench.goals["head_yaw"] == pytest.approx(0.3)
    assert stands(bench)
    assert (bench.setpoint.lease, bench.setpoint.lost) == ("", False)


@pytest.mark.parametrize("seconds", [0.32, 0.42, 0.5, 0.54, 0.56, 0.58])
def test_the_time_that_is_said_is_no_shorter_than_what_it_takes(bench, seconds):
    steps(bench, seconds=seconds)
    said = float(bench.stop().reason.partition("within ")[2].partition(" s")[0])
    assert 0.0 < said <= joints_state(bench.state, bench.now).feet_s + 0.1
    bench.run(said)
    assert stands(bench)


def test_a_lapse_does_so_too_and_its_mover_is_lost_afterwards(bench):
    bench.command(frames=STEP, ttl_s=0.3)
    bench.run(0.32)
    assert bench.results[-1].result == "lapsed"
    assert bench.state.feet is not None
    assert not bench.setpoint.lost
    bench.run(0.5)
    assert bench.goals["left_knee"] == pytest.approx(-0.6)
    assert bench.setpoint.lost


@pytest.mark.parametrize("how", ["again", "other", "estop", "holder", "servos", "latched", "torque", "driver", "clock"])
def test_whatever_else_comes_holds_at_once(bench, how):
    lease = steps(bench)
    if how == "holder":
        bench.lose_holder()
        assert (bench.state.feet, bench.setpoint.lost) == (None, True)
        return
    bench.stop()
    bench.run(0.11)
    assert not stands(bench)
    at, halt = bench.measured("left_knee"), bench.setpoint.halt
    if how == "again":
        assert bench.stop().code == ""
    elif how == "other":
        bench.stop("another")
    elif how == "estop":
        bench.estop()
    elif how == "servos":
        bench.lose_servos()
        bench.run(0.01, hear=False)
    elif how == "latched":
        bench.servos.latched[14] = ("overload",)
        bench.run(0.02)
    elif how == "torque":
        bench.torque("left_knee", on=False)
        bench.run(0.02)
    elif how == "driver":
        bench.servos.obey, bench.servos.phase = lambda _setpoint: None, "holding"
        bench.run(0.02)
    else:
        bench.now -= 5.0
        bench.hear()
    assert bench.state.feet is None
    if how not in {"servos", "clock"}:
        assert bench.setpoint.halt > halt
        assert bench.measured("left_knee") == pytest.approx(at, abs=0.03)
    bench.run(0.5)
    assert bench.goals.get("left_knee", at) != pytest.approx(-0.6)
    assert not bench.command(lease=lease).accepted


def test_a_joint_that_is_held_in_its_step_is_held_where_it_is_and_not_at_its_goal(bench):
    steps(bench)
    bench.stop()
    bench.run(0.11)
    at = bench.measured("left_knee") + 0.03
    bench.push("left_knee", at)
    bench.hear()
    bench.stop()
    assert bench.goals["left_knee"] == pytest.approx(at)


def test_a_driver_that_ceases_to_follow_with_the_stop_holds_at_once(bench):
    steps(bench)
    bench.stop()
    bench.servos.obey, bench.servos.phase = lambda _setpoint: None, "holding"
    bench.run(0.02)
    assert stands(bench)


def test_a_driver_that_does_not_follow_yet_has_time_for_that(bench):
    bench.servos.obey, bench.servos.phase = lambda _setpoint: None, "holding"
    steps(bench, seconds=0.25)
    bench.stop()
    bench.run(0.1)
    assert not stands(bench)


def test_one_stop_by_several_ways_is_one_and_the_next_is_another(bench):
    steps(bench)
    bench.stop("console")
    for source in ("console", "motions"):
        bench.answer(Stop(source=source, by="console", received=bench.now))
    assert not stands(bench)
    bench.run(0.12)
    bench.answer(Stop(source="motions", by="console", received=bench.now))
    assert stands(bench)


def test_a_stop_after_a_lapse_is_the_first(bench):
    bench.command(frames=STEP, ttl_s=0.3)
    bench.run(0.32)
    bench.stop("phone")
    assert not stands(bench)
    bench.run(0.12)
    bench.stop("phone")
    assert stands(bench)
    assert bench.setpoint.lost


def test_that_the_mover_is_lost_is_no_stop_by_hand(bench):
    bench.command(frames=STEP, ttl_s=0.3)
    bench.run(0.32)
    bench.answer(Stop(source="console", received=bench.now, lost=True))
    bench.run(0.12)
    bench.stop("console")
    assert not stands(bench)


def test_a_new_motion_takes_over_from_where_it_is(bench):
    steps(bench)
    bench.stop()
    bench.run(0.1)
    at = bench.goals["left_knee"]
    lease = bench.command({"left_knee": at - 0.1}, speed_rps=0.5).lease
    bench.run(0.01, lease)
    assert bench.state.feet is None
    assert bench.goals["left_knee"] == pytest.approx(at, abs=0.02)


def test_back_to_the_frame_behind_where_the_next_is_too_far(bench):
    far = (*STEP[:1], frame(2.0, left_knee=-1.0, head_yaw=0.6))
    steps(bench, far, 0.5)
    assert bench.goals["left_knee"] < -0.22
    assert bench.stop().code == "to_feet"
    bench.run(LONGEST_S)
    assert bench.goals["left_knee"] == pytest.approx(-0.2)


def test_of_several_frames_behind_it_goes_back_to_the_last(bench):
    stable = tuple(KeyFrame(positions={"left_knee": angle}, duration_s=0.2, stable=True) for angle in (-0.2, -0.4))
    steps(bench, (*stable, frame(2.0, left_knee=-1.0)), 0.7)
    assert bench.stop().code == "to_feet"
    bench.run(LONGEST_S)
    assert bench.goals["left_knee"] == pytest.approx(-0.4)


def test_what_goes_back_to_the_frame_behind_already_goes_on_as_fast(bench):
    there = {"left_knee": -0.2, "head_yaw": 0.0}
    stable = KeyFrame(positions=there, duration_s=0.2, stable=True)
    steps(bench, (stable, frame(0.9, left_knee=-1.3, head_yaw=0.02), frame(2.0, left_knee=0.0, head_yaw=0.0)), 1.7)
    before = bench.goals["left_knee"]
    bench.run(DT)
    by_rad, before = bench.goals["left_knee"] - before, bench.goals["left_knee"]
    assert bench.stop().code == "to_feet"
    bench.run(DT)
    assert bench.goals["left_knee"] - before == pytest.approx(by_rad, rel=0.1)
    bench.run(LONGEST_S)
    assert bench.goals == pytest.approx(dict.fromkeys(bench.goals, 0.0) | there)


@pytest.mark.parametrize("frames", [(frame(0.5, left_knee=-0.6),), (frame(2.0, left_knee=-0.6), STEP[2])])
def test_without_a_stable_frame_in_reach_it_holds_at_once(bench, frames):
    steps(bench, frames, 0.2)
    assert bench.stop().reason == "stopped"
    assert stands(bench)


def test_a_single_joint_is_held_at_once_also_beside_a_motion(bench):
    lease = steps(bench)
    bench.command({"left_shoulder_pitch": 1.0}, join=True, lease=lease)
    bench.run(0.05, lease)
    bench.servos.stuck = {2}
    at = bench.measured("left_shoulder_pitch") - 0.2
    bench.push("left_shoulder_pitch", at)
    bench.hear()
    bench.stop()
    assert bench.goals["left_shoulder_pitch"] == pytest.approx(at)
    at = bench.goals["left_shoulder_pitch"]
    bench.run(0.5)
    assert bench.goals["left_shoulder_pitch"] == at
    assert bench.goals["left_knee"] == pytest.approx(-0.6)


@pytest.mark.parametrize("moment", [at / 20 for at in range(1, 20)])
def test_it_stands_in_time_and_no_joint_is_faster_than_its_row_says(bench, moment):
    steps(bench, seconds=moment)
    bench.stop()
    begun, before = bench.now, dict(bench.goals)
    while not stands(bench):
        bench.run(0.01)
        for name, goal in bench.goals.items():
            assert abs(goal - before[name]) <= bench.state.body.joints[name].speed_rps * 0.01 + 1e-6
        before = dict(bench.goals)
    assert bench.now - begun <= LONGEST_S + 0.02
    rests = dict(bench.goals)
    bench.run(0.5)
    assert bench.goals == rests


def test_a_loop_that_is_held_up_holds_when_its_time_is_over(bench):
    steps(bench)
    bench.stop()
    bench.now += 1.0
    bench.hear()
    bench.run(0.01)
    assert stands(bench)
    assert bench.goals["left_knee"] != pytest.approx(-0.6, abs=0.01)


def test_of_a_loop_that_is_held_up_it_is_said_that_it_takes_no_longer_than_a_stop_may(bench):
    steps(bench)
    bench.stop()
    bench.now += LONGEST_S - 0.2
    assert joints_state(bench.state, bench.now).feet_s == pytest.approx(0.2)


POSE = {"left_knee": -0.5, "right_knee": -0.5}


@pytest.mark.parametrize("stable", [True, False])
def test_what_the_controller_plays_goes_straight_to_its_pose_once_it_was_measured(bench, stable):
    bench.servos.stores = True
    bench.hear()
    motion = StoredMotion(slot=4, duration_s=2.0, pose=POSE, stable=stable)
    lease = bench.command(stored=motion).lease
    bench.run(0.1, lease)
    bench.push("left_knee", -0.3)
    bench.hear()
    bench.servos.mode = "taking"
    halt = bench.setpoint.halt
    assert bench.stop().code == ("to_feet" if stable else "")
    assert bench.setpoint.halt > halt, "the driver breaks it off at once"
    assert bench.setpoint.stored is None
    bench.run(0.1)
    assert bench.measured("left_knee") == pytest.approx(-0.3, abs=0.02)
    bench.servos.mode = "pc"
    bench.run(0.25)
    assert stands(bench) is not stable, "it takes its time, however near that is"
    bench.run(0.45)
    assert bench.measured("left_knee") == pytest.approx(-0.5 if stable else -0.3, abs=0.02)
    assert stands(bench)


def test_a_place_that_was_measured_before_a_stop_is_not_where_its_step_begins(bench):
    bench.servos.stores = True
    bench.hear()
    lease = bench.command(stored=StoredMotion(slot=4, duration_s=2.0, pose=POSE, stable=True)).lease
    bench.run(0.1, lease)
    bench.stop()
    bench.servos.ages_s = {14: 0.2}
    bench.run(0.1)
    assert bench.state.feet.trajectory is None
    bench.servos.ages_s = {}
    bench.run(0.02)
    assert bench.state.feet.trajectory is not None


def test_a_controller_that_does_not_come_back_in_time_is_held(bench):
    bench.servos.stores = True
    bench.hear()
    lease = bench.command(stored=StoredMotion(slot=4, duration_s=2.0, pose=POSE, stable=True)).lease
    bench.run(0.1, lease)
    bench.servos.mode = "taking"
    bench.stop()
    bench.run(LONGEST_S + 0.05)
    assert stands(bench)
    bench.servos.mode = "pc"
    bench.run(0.5)
    assert bench.measured("left_knee") == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize("later", [False, True])
def test_a_stop_that_says_so_holds_at_once(bench, later):
    steps(bench)
    if later:
        bench.stop("console")
    bench.answer(Stop(source="motions", by="console", received=bench.now, at_once=True))
    assert stands(bench)


def test_what_the_controller_was_playing_is_said_to_take_as_long_as_a_stop_may(bench):
    bench.servos.stores = True
    bench.hear()
    lease = bench.command(stored=StoredMotion(slot=4, duration_s=2.0, pose=POSE, stable=True)).lease
    bench.run(0.1, lease)
    bench.servos.mode = "taking"
    assert f"within {LONGEST_S:.1f} s" in bench.stop().reason
    bench.run(0.3)
    assert joints_state(bench.state, bench.now).feet_s == pytest.approx(LONGEST_S - 0.3, abs=0.02)


@pytest.mark.parametrize(("left_s", "goes"), [(0.4, True), (0.2, False)])
def test_a_controller_that_comes_back_goes_to_its_pose_only_if_there_is_time_for_that(bench, left_s, goes):
    bench.servos.stores = True
    bench.hear()
    lease = bench.command(stored=StoredMotion(slot=4, duration_s=2.0, pose=POSE, stable=True)).lease
    bench.run(0.1, lease)
    bench.push("left_knee", -0.3)
    bench.servos.mode = "taking"
    bench.stop()
    bench.run(LONGEST_S - left_s)
    bench.servos.mode = "pc"
    bench.run(0.02)
    assert stands(bench) is not goes
    bench.run(left_s + 0.02)
    assert bench.measured("left_knee") == pytest.approx(-0.5 if goes else -0.3, abs=0.02)
