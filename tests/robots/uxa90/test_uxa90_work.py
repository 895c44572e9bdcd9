"""Motions and jobs of the UXA-90's API: one at a time, cancelled, dropped."""

import msgspec
import pytest

from lbr.apps.web.face import Refused
from lbr.apps.web.kind import WebSettings
from lbr.apps.web.robot import Robot
from lbr.messages.joints import MotionsState
from lbr.robots.uxa90.rest.legacy import Uxa90Face
from tests.robots.uxa90.uxa90_bench import Bench, joints_state


@pytest.fixture
def bench() -> Bench:
    return Bench()


def refusal(call, *arguments, **options) -> tuple[int, str]:
    with pytest.raises(Refused) as caught:
        call(*arguments, **options)
    return caught.value.status, caught.value.message


def test_a_motion_is_answered_when_it_is_accepted_and_renewed_until_it_has_ended(bench):
    answer = bench.play("4")
    assert (answer.data.name, answer.motionMsg.btn_code, answer.message) == ("walk_forward_short", 4, "callMotionById")
    bench.run(1.0)
    assert {message.lease for message in bench.sent("play")[1:]} == {"lease-1"}
    assert len(bench.sent("play")) >= 8
    bench.robot.played = (bench.ended("goal-1"),)
    bench.run()
    before = len(bench.sent("play"))
    bench.run(0.5)
    assert len(bench.sent("play")) == before


@pytest.mark.parametrize(
    ("key", "number", "message"),
    [("Basic_Motion", 1, "callMotionByName"), ("BASIC_MOTION", 1, "callMotionByName"), ("10", 10, "callMotionById"),
     ("0xA", 10, "callMotionById"), (" 7", 7, "callMotionById"), ("sit_down", 21, "callMotionByName"),
     ("walk_foward_4step", 9, "callMotionByName")],
)  # fmt: skip
def test_motions_are_found_by_number_or_name(bench, key, number, message):
    answer = bench.play(key)
    assert (answer.data.id, answer.message) == (number, message)


@pytest.mark.parametrize("key", ["stop", "14", "7up", "walk_forward_4step", "", "4.5", "1e400", "NaN", "-1", "4 5"])
def test_other_motions_do_not_exist(bench, key):
    assert refusal(bench.play, key) == (409, "Motion doesn't exist")


def test_a_motion_that_is_refused_says_why(bench):
    bench.refusal = "emergency stop: pressed; 'reset' releases it"
    assert refusal(bench.play, "4") == (409, "emergency stop: pressed; 'reset' releases it")
    bench.refusal = ""
    bench.play("4")


def test_while_a_motion_plays_nothing_else_moves(bench):
    bench.play("7")
    bench.run(1.0)
    for call, argument in ((bench.motor, "id=23&pos=1"), (bench.play, "4")):
        status, message = refusal(call, argument)
        assert status == 409
        assert message.startswith("busy: 'reset' plays for another 6.0 s") or "5.9" in message
    assert refusal(bench.several, {"id": 23, "pos": 1})[0] == 409
    assert bench.sent() == []


def test_a_motion_that_somebody_else_plays_is_respected(bench):
    bench.say(motions=MotionsState(playing=True, motion="wave", holder="console"))
    assert refusal(bench.motor, "id=23&pos=1") == (409, "busy: 'wave' is played by console")


def test_motions_that_were_not_heard_for_long_keep_nobody_from_moving(bench):
    bench.say(motions=MotionsState(playing=True, motion="wave", holder="console"))
    bench.ctx.now += 2.0
    assert bench.motor("id=23&pos=1").newPosition == 1


def test_motors_are_given_back_before_a_motion_plays(bench):
    bench.motor("id=23&pos=1")
    bench.play("4")
    order = [asked.request for asked in bench.ctx.asked if asked.request != "move"]
    assert order[:2] == ["halt", "play"]
    bench.run(0.5)
    assert not [asked for asked in bench.ctx.asked[-5:] if asked.request == "move"]


def test_pc_control_takes_the_main_board_over_and_disturbs_nothing(bench):
    bench.motor("id=23&pos=1")
    assert bench.play("99").motionMsg.motion_name == "pc_control"
    assert len(bench.sent("take_control")) == 1
    assert bench.sent("halt") == []


def test_a_delayed_move_begins_when_it_is_due(bench):
    answer = bench.motor("id=23&pos=20&delay=500")
    assert (answer.newPosition, answer.job) == (20, "1")
    assert bench.motor("id=23").data.position == 127
    bench.run(0.4)
    assert bench.sent() == []
    bench.run(0.2)
    assert len(bench.sent()) == 1
    assert bench.motor("id=23").data.position == 20
    assert bench.work.jobs.get("1").state == "done"


def test_one_motor_may_be_moved_twice_by_delays(bench):
    answer = bench.several({"id": 23, "pos": 20, "delay": 0}, {"id": 23, "pos": 220, "torq": 4, "delay": 1000})
    assert answer.job == "1"
    assert [round(command.positions["neck_yaw"], 2) for command in bench.sent()] == [1.98]
    bench.run(0.9)
    assert len(bench.sent()) == 1
    assert [step.begun for step in bench.work.jobs.get("1").steps] == [True, False]
    bench.run(0.2)
    assert len(bench.sent()) == 2


def test_a_stop_that_was_not_heard_of_yet_comes_before_a_delayed_move(bench):
    bench.motor("id=23&pos=20&delay=500")
    bench.run(0.4)
    bench.say(joints_state())
    heard = bench.robot.snapshot.joints.arrived
    bench.run(0.2)
    assert [command.asked_s for command in bench.sent()] == [heard]


def test_a_delayed_move_waits_until_the_joints_were_heard_since_the_lease_before(bench):
    bench.motor("id=24&pos=110&delay=500")
    bench.run(0.4)
    bench.say(joints_state())
    bench.motor("id=23&pos=20")
    bench.robot.moved = (bench.ended("goal-1"),)
    bench.run(0.2)
    assert len(bench.sent()) == 1
    bench.say(joints_state())
    bench.run(0.1)
    assert len(bench.sent()) == 2


def test_a_motion_that_waits_for_motors_to_stand_does_not_begin_after_a_stop(bench):
    bench.motor("id=23&pos=1")
    bench.automatic = False
    promise = bench.begin(bench.work.play("4"))
    bench.run()
    bench.work.stopped("stopped by somebody")
    bench.automatic = True
    bench.run(0.5)
    assert refusal(promise.result, 0) == (409, "stopped by somebody")
    assert bench.sent("play") == []


def test_no_motor_takes_the_joints_back_while_a_motion_waits_for_them_to_stand(bench):
    bench.motor("id=23&pos=100")
    bench.automatic = False
    promise = bench.begin(bench.work.play("4"))
    bench.run(0.1)
    assert refusal(bench.motor, "id=24&pos=120") == (409, "busy: 'walk_forward_short' begins")
    assert len(bench.sent()) == 1
    bench.automatic = True
    bench.run(0.1)
    assert promise.result(0).message == "callMotionById"


def test_what_was_to_follow_a_move_is_forgotten_if_a_stop_comes_before_the_move_is_answered(bench):
    bench.automatic = False
    items = [{"id": 23, "pos": 20}, {"id": 24, "pos": 110, "delay": 500}]
    promise = bench.begin(bench.work.several({"motors": items}, {}))
    bench.run()
    bench.work.stopped("stopped by somebody")
    bench.automatic = True
    bench.run(1.0)
    assert refusal(promise.result, 0) == (409, "stopped by somebody")
    assert bench.work.jobs.all() == []
    assert len(bench.sent()) == 1


def test_what_was_due_while_the_server_stood_still_does_not_begin(bench, wording):
    bench.motor("id=23&pos=20&delay=500")
    bench.run(0.1)
    bench.ctx.now += 30.0
    bench.run(0.1)
    assert bench.sent() == []
    wording(bench.work.jobs.get("1").reason)


def test_without_a_delay_there_is_no_job(bench):
    assert b"job" not in msgspec.json.encode(bench.several({"id": 23, "pos": 20, "delay": 0}))
    assert bench.work.jobs.all() == []


def test_what_is_cancelled_does_not_begin(bench):
    bench.motor("id=23&pos=20&delay=500")
    assert bench.work.jobs.cancel("1").state == "cancelled"
    bench.run(1.0)
    assert bench.sent() == []
    assert refusal(bench.work.jobs.cancel, "1")[0] == 409
    assert refusal(bench.work.jobs.get, "2")[0] == 404


@pytest.mark.parametrize(
    "ask",
    [
        lambda bench, came_s: bench.motor("id=24&pos=110", came_s=came_s),
        lambda bench, came_s: bench.several({"id": 24, "pos": 110}, came_s=came_s),
        lambda bench, came_s: bench.play("4", came_s),
    ],
    ids=["motor", "several", "motion"],
)
def test_what_began_to_come_before_a_stop_and_is_whole_after_it_moves_nothing(bench, ask):
    bench.say(joints_state(stopped_s=5.0, stopped_by="console"))
    status, why = refusal(ask, bench, 4.0)
    assert (status, why) == (409, "the robot was stopped by console after this was sent")
    bench.run(0.5)
    assert bench.sent() == bench.sent("play") == []
    ask(bench, 5.1)
    assert bench.sent() + bench.sent("play")


@pytest.mark.parametrize("how", ["stop", "estop", "server", "lost", "motion", "other_motion"])
def test_stops_and_motions_drop_jobs(bench, how):
    bench.say(joints_state(stopped_s=None))
    bench.motor("id=24&pos=110")
    bench.motor("id=23&pos=20&delay=500")
    match how:
        case "stop":
            bench.say(joints_state(stopped_s=1.0))
        case "estop":
            bench.say(joints_state(estop=True))
        case "server":
            bench.work.stopped("stopped by 127.0.0.1")
        case "lost":
            bench.robot.moved = (bench.ended("goal-1", "fault", "head_pitch is not followed"),)
        case "motion":
            bench.play("4")
        case "other_motion":
            bench.say(joints_state(stopped_s=None), MotionsState(playing=True, motion="wave", holder="console"))
    bench.run(1.0)
    job = bench.work.jobs.get("1")
    assert (job.state, bool(job.reason), job.steps[0].begun) == ("dropped", True, False)
    assert len(bench.sent()) == 1


def test_a_job_that_is_refused_when_due_is_dropped_with_the_reason(bench):
    bench.motor("id=23&pos=20&delay=100")
    bench.refusal = "held by tracking"
    bench.run(0.3)
    job = bench.work.jobs.get("1")
    assert (job.state, job.reason, job.steps[0].begun) == ("dropped", "held by tracking", False)
    assert bench.ctx.events == [("job_dropped", "job 1 was dropped: held by tracking")]


def test_jobs_are_so_many_and_no_more(bench):
    for _ in range(64):
        bench.motor("id=23&pos=20&delay=60000")
    assert refusal(bench.motor, "id=23&pos=20&delay=1")[0] == 429
    bench.work.jobs.drop("enough")
    for _ in range(400):
        bench.motor("id=23&pos=20&delay=60000")
        bench.work.jobs.drop("enough")
    assert len(bench.work.jobs.all()) <= 257


def test_nothing_waits_while_the_emergency_stop_is_latched(bench):
    bench.say(joints_state(estop=True, reason="emergency stop: smoke"))
    assert refusal(bench.motor, "id=23&pos=20&delay=100") == (
        409,
        "emergency stop: smoke; 'reset' releases it",
    )


def test_joints_that_do_not_answer_end_the_lease(bench):
    bench.motor("id=23&pos=20")
    bench.automatic = False
    bench.run(1.0)
    assert not bench.work._mover.holds


def test_the_state_says_what_goes_on(bench):
    bench.motor("id=23&pos=20")
    state = bench.work.state()
    assert (state["positions"]["23"], state["moving"], state["busy"], state["jobs"]) == (20, True, "", 0)


@pytest.mark.parametrize(("layer", "told"), [("safe", 0), ("save", 1)])
def test_a_layer_that_no_motor_has_is_told(bench, layer, told):
    bench.ctx.settings = WebSettings(faces=("uxa90",), layer=layer)
    Uxa90Face(Robot(bench.ctx, bench.bridge, None, None))
    assert [one for one in bench.ctx.events if "there are api, factory, safe" in one[1]] == bench.ctx.events
    assert len(bench.ctx.events) == told
