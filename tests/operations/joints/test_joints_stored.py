"""Motions that the servos' controller plays by itself: who may have them played, and what ends them."""

import pytest

from lbr.drivers.servos.gate import first, receive, tick
from lbr.messages.joints import StoredMotion
from lbr.operations.joints.state import Tick
from lbr.operations.joints.view import joints_state
from lbr.robots.uxa90.driver import stored_motions
from tests.operations.joints.joints_bench import NAMES, Bench

WALK = StoredMotion(slot=4, duration_s=2.0, pose={"left_knee": -0.4})
SIT = StoredMotion(slot=21, duration_s=1.0, limp=True)


@pytest.fixture
def bench():
    made = Bench()
    made.servos.stores = True
    return made.run(0.05)


def last(bench):
    return bench.results[-1].result, bench.results[-1].reason


def test_the_driver_is_told_slot_and_duration_until_it_says_that_it_is_over(bench):
    reply = bench.command(stored=WALK)
    assert reply.accepted
    play = bench.setpoint.stored
    assert (play.slot, play.duration_s, play.limp) == (4, 2.0, False)
    assert {goal.torque for goal in bench.setpoint.goals} == {0.0}, "nothing gets torque before it is known to play"
    bench.run(1.5, reply.lease)
    assert bench.setpoint.stored == play
    assert {goal.torque for goal in bench.setpoint.goals} == {1.0}
    assert {goal.position_rad for goal in bench.setpoint.goals} == {None}
    state = joints_state(bench.state, bench.now)
    assert (state.stored, state.moving, state.holder) == (4, True, "console")
    assert state.left_s == pytest.approx(0.5, abs=0.05)
    bench.push("left_knee", -0.42)
    bench.servos.plays("over")
    bench.run(0.02, reply.lease)
    assert last(bench) == ("reached", bench.results[-1].reason)
    assert bench.setpoint.stored is None
    assert bench.goals["left_knee"] == -0.4, "at its pose, if it is about there"
    assert set(bench.goals) == set(NAMES)
    assert joints_state(bench.state, bench.now).stored is None


def test_who_is_elsewhere_than_the_pose_says_is_held_there(bench):
    reply = bench.command(stored=WALK)
    bench.run(0.1, reply.lease)
    bench.push("left_knee", -0.9)
    bench.servos.plays("over")
    bench.run(0.02, reply.lease)
    assert bench.goals["left_knee"] == pytest.approx(-0.9)


@pytest.mark.parametrize(("age_s", "rests_at"), [(0.03, -0.9), (0.06, -0.4)])
def test_only_what_was_measured_just_now_is_known_to_be_elsewhere_than_the_pose(bench, age_s, rests_at):
    reply = bench.command(stored=WALK)
    bench.run(0.1, reply.lease)
    bench.push("left_knee", -0.9)
    bench.servos.ages_s[14] = age_s
    bench.servos.plays("over")
    bench.hear()
    bench.give(Tick())
    assert bench.goals["left_knee"] == pytest.approx(rests_at)


def test_who_is_outside_its_limits_afterwards_is_held_where_it_is(bench):
    reply = bench.command(stored=WALK)
    bench.run(0.1, reply.lease)
    bench.push("left_knee", -2.3)
    bench.servos.plays("over")
    bench.hear()
    bench.give(Tick())
    assert bench.goals["left_knee"] is None


def test_after_a_limp_one_no_joint_has_torque(bench):
    reply = bench.command(stored=SIT)
    assert bench.setpoint.stored.limp
    bench.run(0.1, reply.lease)
    bench.servos.plays("over")
    bench.run(0.02, reply.lease)
    assert bench.goals == {}
    assert last(bench)[0] == "reached"
    assert bench.torque("left_knee", on=True).accepted
    bench.run(0.03)
    assert bench.goals == {}, "the driver is to hear of them without torque first"
    bench.run(0.1)
    assert set(bench.goals) == {"left_knee"}


def test_what_the_controller_plays_has_full_torque_whatever_was_asked_for_before(bench):
    lease = bench.command({"left_knee": -0.5}, torque=0.4).lease
    bench.run(0.05, lease)
    assert bench.command(stored=WALK, lease=lease).accepted
    bench.run(0.1, lease)
    assert {goal.torque for goal in bench.setpoint.goals} == {1.0}


def test_a_servo_that_is_heard_only_after_a_limp_one_has_no_torque_either(bench):
    bench.servos.missing = {20}
    bench.restart()
    reply = bench.run(0.05).command(stored=SIT)
    bench.run(0.1, reply.lease)
    bench.servos.plays("over")
    bench.run(0.02, reply.lease)
    bench.servos.missing, bench.servos.torque[20] = set(), 1.0
    bench.hear()
    bench.run(0.2)
    assert bench.goals == {}


def test_what_latches_while_the_controller_plays_is_told_afterwards(bench):
    reply = bench.command(stored=WALK)
    bench.run(0.1, reply.lease)
    bench.servos.latched = {14: ("overload",)}
    bench.run(0.1, reply.lease)
    assert ("left_knee" in bench.state.on, bench.events[-1].kind) == (True, "holder")
    bench.servos.plays("over")
    bench.run(0.02, reply.lease)
    assert ("left_knee" in bench.state.on, bench.events[-1].code) == (False, "latched")


def test_a_driver_that_never_says_over_is_believed_by_its_time(bench):
    reply = bench.command(stored=SIT)
    bench.run(3.9, reply.lease)
    assert bench.results == []
    bench.run(0.2, reply.lease)
    assert last(bench)[0] == "reached"


def test_nothing_else_moves_meanwhile_and_who_asks_is_told_for_how_long(bench, wording):
    reply = bench.command(stored=WALK)
    bench.run(0.5, reply.lease)
    told = bench.command({"left_knee": -0.1}, lease=reply.lease).reason
    wording(told)
    assert bench.command({"left_knee": -0.1}, join=True, lease=reply.lease).reason == told
    assert bench.command(stored=SIT, lease=reply.lease).reason == told
    assert bench.command({"left_knee": -0.1}, source="pad").reason == f"{told}, held by console"
    assert bench.torque("left_knee", on=True).reason == told
    assert bench.results == []


def test_each_is_told_with_a_count_that_grows_also_after_a_process_began_anew(bench):
    counts = []
    for _ in range(3):
        reply = bench.command(stored=SIT)
        counts.append(bench.setpoint.stored.count)
        bench.servos.plays("over")
        bench.run(0.02, reply.lease)
        bench.restart()
        bench.run(0.05)
    assert counts == sorted(set(counts))


@pytest.mark.parametrize("how", ["stop", "lapse", "holder", "estop"])
def test_whatever_ends_it_is_told_to_the_driver_which_then_holds(bench, how):
    reply = bench.command(stored=WALK)
    bench.run(0.3, reply.lease)
    halt = bench.setpoint.halt
    if how == "stop":
        bench.stop()
    elif how == "lapse":
        bench.run(0.4)
    elif how == "holder":
        bench.lose_holder()
    else:
        bench.estop()
    assert bench.setpoint.stored is None
    assert bench.setpoint.halt > halt
    assert bench.setpoint.lost == (how in {"lapse", "holder"})
    assert last(bench)[0] == {"stop": "stopped", "estop": "fault"}.get(how, "lapsed")
    assert set(bench.goals) == set(NAMES)


def test_a_process_that_is_killed_meanwhile_says_nothing_of_it_afterwards(bench):
    reply = bench.command(stored=WALK)
    bench.run(0.3, reply.lease)
    bench.servos.phase = "holding"
    bench.restart()
    bench.run(0.3)
    assert bench.setpoint.lost
    assert bench.setpoint.stored is None
    assert not bench.command(lease=reply.lease).accepted


class Line:
    """What the driver makes of setpoints: whether it follows, and what its controller plays."""

    def __init__(self, now):
        self.mover, self.plays, self.started = first(now), stored_motions.StoredMotions(begun=True), []

    def hear(self, setpoint, now):
        self.mover = receive(self.mover, setpoint, now, now, 0.1)
        self.plays = stored_motions.seen(self.plays, setpoint.stored, (4, 21), follows=self.mover.follows)
        if self.plays.wanted:
            self.started.append(setpoint.stored.count)
            self.plays = stored_motions.started(self.plays, now)

    def silence(self, now):
        self.mover = tick(self.mover, now, 0.1)
        if not self.mover.follows:
            self.plays = stored_motions.interrupted(self.plays, self.mover.reason, self.mover.code)


def test_for_the_driver_a_killed_process_is_silence_and_the_next_one_starts_nothing_by_itself(bench):
    line = Line(bench.now)
    reply = bench.command(stored=WALK)
    for _ in range(30):
        line.hear(bench.setpoint, bench.now)
        bench.run(0.01, reply.lease)
    assert len(line.started) == 1
    bench.now += 0.2
    line.silence(bench.now)
    assert (line.plays.phase, line.plays.code) == ("failed", "no_setpoint")
    bench.servos.phase = "holding"
    bench.restart()
    for _ in range(30):
        bench.run(0.01)
        if bench.setpoint is not None:
            line.hear(bench.setpoint, bench.now)
    assert not line.mover.follows
    assert len(line.started) == 1
    anew = bench.command(stored=SIT)
    assert anew.accepted
    line.hear(bench.setpoint, bench.now)
    assert len(line.started) == 2
    assert line.started == sorted(line.started)


def test_who_takes_over_breaks_it_off(bench):
    first = bench.command(stored=WALK)
    bench.run(0.2, first.lease)
    halt = bench.setpoint.halt
    assert bench.command({"left_knee": -0.1}, source="pad", take_over=True).accepted
    assert last(bench) == ("superseded", "taken over by pad")
    assert bench.setpoint.stored is None
    assert bench.setpoint.halt > halt


def test_what_the_driver_could_not_begin_leaves_every_joint_as_it_was(bench):
    bench.torque("left_knee", on=True)
    reply = bench.command(stored=WALK)
    bench.servos.plays("failed", "slot 4 is not among those that may be started")
    bench.run(0.02, reply.lease)
    assert last(bench) == ("fault", "slot 4 is not among those that may be started")
    assert set(bench.goals) == {"left_knee"}


def test_a_driver_that_does_not_take_it_up_ends_it(bench, wording):
    bench.servos._play = lambda setpoint: None
    bench.servos.reason = "the cable is out"
    reply = bench.command(stored=WALK)
    bench.run(1.1, reply.lease)
    wording(*last(bench))


def test_a_controller_that_waits_for_longer_than_it_would_play_has_failed(bench, wording):
    reply = bench.command(stored=SIT)
    bench.servos.plays("waiting")
    bench.run(3.9, reply.lease)
    assert bench.results == []
    bench.run(0.2, reply.lease)
    assert bench.results[-1].code == "timeout"
    wording(*last(bench))


def test_a_driver_that_is_gone_ends_it(bench):
    bench.command(stored=WALK)
    bench.lose_servos()
    assert last(bench) == ("fault", "the servo driver (servos) is gone")


@pytest.mark.parametrize(
    "command",
    [
        {"positions": {"left_knee": 0.0}},
        {"torque": 0.4},
        {"stored": StoredMotion(slot=4, duration_s=float("nan"))},
        {"stored": StoredMotion(slot=4, duration_s=0.0)},
        {"stored": StoredMotion(slot=4, duration_s=1.0, pose={"tail": 0.0})},
    ],
)
def test_one_that_makes_no_sense_is_refused(bench, command, wording):
    wording(bench.command(**{"stored": WALK, **command}))
    assert bench.state.move is None


def test_a_controller_without_motions_plays_none(bench, wording):
    bench.servos.stores = False
    bench.hear()
    wording(bench.command(stored=WALK))


def test_nothing_goes_on_while_the_controller_does_not_pass_goals_on(bench):
    bench.torque(on=True)
    bench.servos.mode = "taking"
    bench.run(0.05)
    bench.servos.obey = lambda setpoint: None
    bench.servos.phase = "holding"
    reply = bench.command({"left_knee": -0.5}, join=True)
    bench.run(1.0, reply.lease)
    assert bench.goals["left_knee"] == 0.0
    assert bench.results == []
    del bench.servos.obey
    bench.servos.mode = "pc"
    bench.run(0.5, reply.lease)
    assert last(bench)[0] == "reached"
    assert bench.goals["left_knee"] == -0.5


@pytest.mark.parametrize("afterwards", ["over", "playing", "failed"])
def test_what_was_stopped_is_told_as_stopped_whatever_the_controller_does_afterwards(bench, afterwards):
    reply = bench.command(stored=WALK)
    bench.run(0.5, reply.lease)
    bench.stop("phone")
    bench.servos.plays(afterwards)
    bench.run(6.0)
    assert [(result.goal, result.result, result.reason) for result in bench.results] == [
        (reply.goal, "stopped", "stopped by phone: test")
    ]
