"""The process around the kernel: what it publishes when, whom it asks, and what it does when things end."""

import re
from pathlib import Path

import msgspec
import pytest
from msgspec import structs
from msgspec.structs import replace

from lbr.bus import keys
from lbr.bus.wire import MAX_WAITING_COMMANDS
from lbr.capability.stage import Stage, alone
from lbr.messages.attitude import AttitudeState
from lbr.messages.drive import CheckVerdict, DriveCommand
from lbr.messages.odometry import OdometryState
from lbr.operations.drive import KIND
from lbr.operations.drive.capability import Drive
from lbr.operations.drive.settings import DEFAULT_RULES, Rule
from lbr.operations.lender import MOST_WAITING, mark
from tests.operations.drive.drive_bench import motors, ranges
from tests.operations.drive.drive_context import DriveContext


class Robot:
    """A drive capability in its loop: 50 steps a second, sensors at 10 Hz."""

    def __init__(self, **settings):
        self.ctx = DriveContext(**settings)
        self.drive = Drive(self.ctx)
        self.ctx.hear()
        self.drive.open()
        self.ctx.now += 0.02  # what was not sent after it began, begins nothing

    def send(self, call):
        self.drive.command(call)
        return call

    def run(self, seconds, renew=None, hear=True):
        for step in range(round(seconds * 50)):
            self.ctx.now = round(self.ctx.now + 0.02, 6)
            if step % 5 == 0:
                if hear:
                    self.ctx.hear()
                if renew:
                    renew()
            self.drive.step()

    @property
    def wheels(self):
        last = self.ctx.said("setpoint")[-1]
        return last.left, last.right


@pytest.fixture
def robot():
    return Robot()


def renewing(robot, call, power=0.5):
    return lambda: robot.send(robot.ctx.command(power, lease=call.answer.lease))


def test_the_kind_names_the_class_that_runs():
    assert KIND.load() is Drive
    assert KIND.moves
    assert KIND.parse("{}") == DriveContext().settings


def test_a_row_that_says_nothing_holds_what_the_reference_says():
    page = Path(__file__).parents[3] / "docs" / "reference" / "settings.md"
    section = page.read_text().partition("## Kind `drive`")[2].partition("\n## ")[0]
    told = dict(re.findall(r"^\|`(\w+)`\|`([^`]*)`\|", section, re.MULTILINE))
    row = structs.asdict(Rule(direction="forward", sensor="forward")) | structs.asdict(KIND.parse("{}"))
    assert {name: msgspec.json.decode(text) for name, text in told.items()} == {name: row[name] for name in told}
    assert row.keys() - told.keys() == {"direction", "sensor", "rules"}
    sides = [(rule.direction, rule.stop_m, rule.frozen_after_m) for rule in DEFAULT_RULES]
    assert sides == [("forward", 0.25, 0.1), ("back", 0.25, 0.1), ("left", 0.2, 0.3), ("right", 0.2, 0.3)]


@pytest.mark.parametrize(
    ("row", "complaint"),
    [
        ('{"rate_hz": 10}', r"\$.rate_hz"),
        ('{"max_powr": 1}', "unknown field `max_powr`"),
        ('{"rules": [{"direction": "up", "sensor": "forward"}]}', r"\$.rules\[0\].direction"),
        ('{"rules": [{"direction": "back", "sensor": "back", "max_age_s": 60}]}', r"\$.rules\[0\].max_age_s"),
        ('{"ttl_s": 3}', r"\$.ttl_s"),
    ],
)
def test_a_bad_row_is_refused_naming_the_field(row, complaint):
    with pytest.raises(msgspec.ValidationError, match=complaint):
        KIND.parse(row)


@pytest.mark.parametrize(
    ("armed", "holds", "least", "most"), [(True, False, 4, 4), (True, True, 100, 101), (False, False, 100, 101)]
)
def test_zero_is_published_from_the_start_and_twice_a_second_once_armed_motors_rest(robot, armed, holds, least, most):
    call = robot.send(robot.ctx.command(0.5)) if holds else None

    def goes_on():
        robot.ctx.hear(armed=armed)
        if call is not None:
            robot.send(robot.ctx.command(0.0, lease=call.answer.lease))

    goes_on()
    for seconds in (0.6, 2.0):
        robot.ctx.published.clear()
        robot.run(seconds, goes_on, hear=False)
        setpoints = robot.ctx.said("setpoint")
        assert {(each.left, each.right, each.moving_s) for each in setpoints} == {(0.0, 0.0, 0.0)}
        assert len(setpoints) >= (23 if seconds < 1.0 else least)
    assert len(setpoints) <= most


def ramp(robot, seconds):
    """The setpoints of a motion that begins now, with their times from its beginning."""
    robot.ctx.published.clear()
    began, said = robot.ctx.now, []
    call = robot.send(robot.ctx.command(0.5))
    for _ in range(round(seconds * 1000)):
        said += [(round(robot.ctx.now - began, 3), one) for one in robot.ctx.said("setpoint")]
        robot.ctx.published.clear()
        robot.drive.step()
        said += [(round(robot.ctx.now - began, 3), one) for one in robot.ctx.said("setpoint")]
        robot.ctx.published.clear()
        robot.ctx.now = round(robot.ctx.now + 0.001, 6)
    robot.send(robot.ctx.stop())
    return call, said


@pytest.mark.parametrize("rest_s", [0.0, 0.3, 0.6, 1.1, 7.93])
def test_a_motion_begins_at_once_and_with_a_nominal_step_however_long_the_base_rested(robot, rest_s):
    robot.run(0.1)
    robot.run(rest_s)
    robot.ctx.now = round(robot.ctx.now + 0.007, 6)
    _, said = ramp(robot, 0.2)
    step = robot.ctx.settings.accel_per_s / robot.ctx.settings.rate_hz
    moving = [(at, one.left, one.moving_s) for at, one in said if one.left]
    assert moving[0][0] <= 0.013  # at once, or where the loop's last round was a moment ago, with its next
    assert all(left <= (number + 1) * step + 1e-9 for number, (_, left, _) in enumerate(moving))
    if rest_s > 0.5:
        assert moving[0] == (0.0, pytest.approx(step), 0.0)
        assert [at for at, *_ in moving] == pytest.approx([0.02 * number for number in range(len(moving))], abs=0.0021)
    assert all(age == pytest.approx(at - moving[0][0]) for at, _, age in moving)


def test_the_loop_keeps_its_rate_however_often_it_is_woken(robot):
    call = robot.send(robot.ctx.command(0.5))
    robot.ctx.published.clear()
    for number in range(1000):
        robot.ctx.now += 0.002
        if number % 50 == 0:
            robot.ctx.hear()
            robot.send(robot.ctx.command(0.5, lease=call.answer.lease))
        robot.drive.step()
    assert len(robot.ctx.said("setpoint")) == pytest.approx(100, abs=2)


def test_a_faster_rate_is_a_setting():
    assert Robot(rate_hz=100).drive.rate_hz == 100


def test_lease_ids_do_not_repeat_and_cannot_be_guessed(robot):
    leases = set()
    for _ in range(20):
        robot.ctx.now += 0.001
        leases.add(robot.send(robot.ctx.command(0.5)).answer.lease)
        robot.send(robot.ctx.stop())
    assert len(leases) == 20
    assert {len(lease) for lease in leases} == {16}


def test_a_stop_is_obeyed_and_answered_at_once(robot):
    call = robot.send(robot.ctx.command(0.5))
    robot.run(0.4, renewing(robot, call))
    assert robot.drive.not_at_rest()
    assert robot.send(robot.ctx.stop()).answer.accepted
    assert (robot.wheels, robot.drive.not_at_rest()) == ((0.0, 0.0), "")
    assert robot.ctx.said("state")[-1].reason == "stopped by phone: test"


def test_the_emergency_stop_is_obeyed_acknowledged_and_shown(robot):
    call = robot.send(robot.ctx.command(0.5))
    robot.run(0.4, renewing(robot, call))
    robot.ctx.estop.engaged, robot.ctx.estop.reason = True, "button"
    robot.drive.step()
    assert robot.wheels == (0.0, 0.0)
    assert robot.ctx.estop.acknowledged == [(True, "")]
    assert robot.ctx.said("state")[-1].estop
    assert robot.send(robot.ctx.command(0.5)).answer.reason == "emergency stop: button; 'reset' releases it"


def test_a_latch_from_before_the_start_is_obeyed():
    ctx = DriveContext()
    ctx.estop.engaged = True
    ctx.hear()
    drive = Drive(ctx)
    drive.open()
    call = ctx.command(0.5)
    drive.command(call)
    assert call.answer.reason.startswith("emergency stop")


def test_it_is_ready_once_all_that_feeds_it_has_come_and_the_motors_are_armed():
    robot = Robot()
    robot.ctx.wired["scans"] = ()
    robot.run(0.1)
    assert (robot.drive.lacks().code, robot.drive.lacks().text) == (
        "not_ready",
        "nothing has come from attitude, odometry yet",
    )
    attitude(robot)
    robot.ctx.arrive("odometry", OdometryState(valid=False, epoch="e"))
    robot.ctx.arrive("motors", motors(armed=False, reason="no zero setpoint yet"))
    robot.drive.step()
    assert (robot.drive.lacks().code, robot.ctx.estop.follows) == ("not_armed", False)
    robot.run(0.1)
    assert (robot.drive.lacks(), robot.ctx.estop.follows) == (None, True)
    robot.ctx.estop.engaged = True
    robot.drive.step()
    assert robot.drive.lacks().code == "estop"


def test_of_several_motor_drivers_the_death_of_the_last_ends_the_motion(robot):
    robot.ctx.wired["motors"] = ("left_motors", "right_motors")
    call = robot.send(robot.ctx.command(0.5))
    robot.run(0.2, renewing(robot, call))
    robot.ctx.gone.add("left_motors")
    robot.run(0.1, renewing(robot, call))
    assert robot.wheels != (0.0, 0.0)
    robot.ctx.gone.add("right_motors")
    robot.drive.step()
    assert robot.wheels == (0.0, 0.0)
    assert ("fault", "console: the motor driver (left_motors, right_motors) is gone") in robot.ctx.events


def test_the_death_of_a_capability_that_drives_ends_its_motion(robot):
    call = robot.send(robot.ctx.command(0.5))
    robot.run(0.1, renewing(robot, call))
    robot.ctx.gone.add("console")
    robot.drive.step()
    assert robot.wheels == (0.0, 0.0)
    assert ("lapsed", "console: the process of console is gone") in robot.ctx.events


def test_a_flood_by_others_does_not_take_the_lease_of_the_one_who_holds_it():
    stage = Stage()
    config = alone(KIND, name="drive")
    stage.add(replace(config, requests={request: {} for request in config.requests}))
    key, setpoints = keys.port(stage.robot, "drive", "command"), stage.hear("drive", "setpoint")

    def feed():
        stage.arrive("drive", "motors", motors())
        stage.arrive("drive", "ranges", ranges())

    stage.run(0.3, (feed,))
    lease = stage.answer("drive", "command", DriveCommand(power=0.5), "console").lease
    for _ in range(10):
        for other in range(2 * MAX_WAITING_COMMANDS):
            stage.put(key, DriveCommand(power=0.5), f"other{other % 15}")
        stage.command("drive", "command", DriveCommand(power=0.5, lease=lease), "console")
        stage.run(0.1, (feed,))
    assert setpoints[-1].lease == mark(lease)
    assert setpoints[-1].left > 0.0


def test_no_more_than_sixteen_commands_wait_for_checks(robot):
    robot.ctx.checks = None
    calls = [robot.send(robot.ctx.command(0.5, source=f"phone{number}")) for number in range(MOST_WAITING + 1)]
    assert MOST_WAITING == 16
    assert [call.answer for call in calls[:-1]] == [None] * MOST_WAITING
    assert calls[-1].answer.code == "busy"


def test_a_computer_that_slept_has_ended_every_motion_and_begins_none_from_before(robot):
    call = robot.send(robot.ctx.command(0.5))
    robot.run(0.5, renewing(robot, call))
    assert robot.wheels != (0.0, 0.0)
    sent_before = robot.ctx.command(0.5)
    robot.ctx.now += 0.01
    robot.drive.woke(3600.0)
    robot.run(0.02)
    assert robot.wheels == (0.0, 0.0)
    assert "slept for 3600 s" in robot.ctx.said("state")[-1].reason
    assert not robot.send(robot.ctx.command(0.5, lease=call.answer.lease)).answer.accepted
    assert not robot.send(sent_before).answer.accepted
    assert robot.send(robot.ctx.command(0.5)).answer.accepted


def test_a_driver_that_is_back_can_be_driven_again(robot):
    robot.ctx.drivers_alive = False
    robot.run(0.1, hear=False)
    assert not robot.send(robot.ctx.command(0.5)).answer.accepted
    robot.ctx.drivers_alive = True
    robot.run(0.1)
    assert robot.send(robot.ctx.command(0.5)).answer.accepted


def test_new_and_changed_motion_is_shown_to_the_checks_but_no_renewal(robot):
    call = robot.send(robot.ctx.command(0.5))
    for power in (0.5, 0.5, 0.5, 0.3, 0.0):
        robot.ctx.now += 0.01
        robot.send(robot.ctx.command(power, lease=call.answer.lease))
    assert [asked.message.command.power for asked in robot.ctx.asked] == [0.5, 0.3]
    assert robot.ctx.asked[0].message.source == "console"


def test_what_is_refused_anyway_is_not_shown_to_the_checks(robot):
    robot.send(robot.ctx.command(0.5, lease="dead"))
    assert robot.ctx.asked == []


@pytest.mark.parametrize(
    ("answers", "reason"),
    [
        ({"cliff": CheckVerdict(accepted=False, reason="a cliff")}, "check cliff: a cliff"),
        ({"cliff": None}, "check cliff did not answer"),
        ({"cliff": {"accepted": "yes"}}, "check cliff did not answer"),
    ],
)
def test_a_check_that_refuses_or_is_silent_refuses_the_command(robot, answers, reason):
    robot.ctx.checks = answers
    assert robot.send(robot.ctx.command(0.5)).answer.reason == reason


def test_the_loop_goes_on_while_a_check_thinks(robot):
    robot.ctx.checks = None
    call = robot.send(robot.ctx.command(0.5))
    before = len(robot.ctx.said("setpoint"))
    robot.run(0.08)
    assert call.answer is None
    assert len(robot.ctx.said("setpoint")) == before + 4
    robot.ctx.asked[0].given = {"cliff": CheckVerdict(accepted=True)}
    robot.drive.step()
    assert call.answer.accepted


def test_a_stop_while_a_check_thinks_is_the_last_word(robot):
    robot.ctx.checks = None
    call = robot.send(robot.ctx.command(0.5))
    robot.ctx.now += 0.01
    robot.send(robot.ctx.stop())
    robot.ctx.asked[0].given = {"cliff": CheckVerdict(accepted=True)}
    robot.run(0.1)
    assert call.answer.code == "stopped"
    assert robot.wheels == (0.0, 0.0)


def test_a_check_that_never_answers_is_not_waited_for(robot):
    robot.ctx.checks = None
    call = robot.send(robot.ctx.command(0.5))
    robot.run(0.3)
    assert "did not answer" in call.answer.reason


def test_commands_are_decided_in_the_order_they_came(robot):
    robot.ctx.checks = None
    first, second = (robot.send(robot.ctx.command(0.5, source=name)) for name in ("a", "b"))
    robot.ctx.asked[1].given = {}
    robot.drive.step()
    assert second.answer is None
    robot.ctx.asked[0].given = {}
    robot.drive.step()
    assert first.answer.accepted
    assert second.answer.reason == "held by a; stop it first"


def test_the_state_comes_twice_a_second_at_rest_ten_times_while_the_base_is_held_and_at_once_on_change(robot):
    robot.ctx.published.clear()
    robot.run(2.0)
    assert 3 <= len(robot.ctx.said("state")) <= 5
    before = len(robot.ctx.said("state"))
    call = robot.send(robot.ctx.command(0.5))
    assert len(robot.ctx.said("state")) == before + 1
    assert robot.ctx.said("state")[-1].holder == "console"
    robot.run(1.0, lambda: robot.send(robot.ctx.command(0.5, lease=call.answer.lease)))
    assert 9 <= len(robot.ctx.said("state")) - before <= 12


def test_the_state_carries_the_loops_statistics(robot):
    call = robot.send(robot.ctx.command(0.5))
    robot.run(0.5, renewing(robot, call))
    assert robot.ctx.said("state")[-1].loop is None
    robot.run(1.0, renewing(robot, call))
    loop = robot.ctx.said("state")[-1].loop
    assert loop.rate_hz == pytest.approx(50, abs=1)
    assert loop.period_p99_ms == pytest.approx(20, abs=0.1)
    assert loop.overruns == 0


def test_the_result_of_a_bounded_move_is_published(robot):
    call = robot.send(robot.ctx.command(0.5, interval_s=0.5))
    robot.run(0.6, lambda: robot.send(robot.ctx.command(0.5, interval_s=0.5, lease=call.answer.lease)))
    (result,) = robot.ctx.said("result")
    assert (result.goal, result.result) == (call.answer.goal, "interval")


def test_closing_publishes_zero_and_answers_whoever_waits(robot):
    call = robot.send(robot.ctx.command(0.5, interval_s=5.0))
    robot.run(0.2)
    robot.ctx.checks = None
    waiting = robot.send(robot.ctx.command(0.5, source="phone", take_over=True))
    robot.drive.close()
    assert robot.wheels == (0.0, 0.0)
    assert waiting.answer.reason == "drive operations end"
    assert robot.ctx.said("result")[-1].goal == call.answer.goal


def test_a_reopened_capability_knows_no_lease_from_before(robot):
    call = robot.send(robot.ctx.command(0.5))
    robot.drive.close()
    robot.drive.open()
    robot.run(0.1)
    assert "lease is dead" in robot.send(robot.ctx.command(0.5, lease=call.answer.lease)).answer.reason


def test_a_new_drive_is_not_moved_by_what_was_sent_before_it_began(robot):
    robot.run(0.1)
    early = robot.ctx.command(0.5)
    robot.drive.close()
    robot.run(0.1, hear=False)
    robot.drive = Drive(robot.ctx)
    robot.drive.open()
    robot.ctx.now += 0.02
    robot.ctx.hear()
    assert robot.send(early).answer.code == "stopped"
    robot.run(0.1)
    assert robot.wheels == (0.0, 0.0)
    assert robot.send(robot.ctx.command(0.5)).answer.accepted


def test_an_unknown_command_is_refused(robot):
    call = robot.ctx.command(0.5)
    call.name = "fly"
    assert robot.send(call).answer.reason == "fly is not understood here"


def test_a_command_from_afar_waits_for_its_confirmation_and_the_state_says_so(robot):
    call = robot.ctx.command(0.5, source="page")
    call.remote = True
    robot.send(call)
    robot.run(0.1)
    assert robot.wheels == (0.0, 0.0)
    assert robot.ctx.said("state")[-1].reason == "waiting for page to confirm"
    again = robot.ctx.command(0.5, source="page", lease=call.answer.lease)
    again.remote, again.answerable = True, False
    assert robot.send(again).answer.accepted
    robot.run(0.1)
    assert robot.wheels != (0.0, 0.0)


def test_changes_of_holder_are_events_in_words_and_as_data(robot, wording):
    robot.send(robot.ctx.command(0.5))
    robot.run(0.4)
    told = [
        (text, data) for (kind, text), data in zip(robot.ctx.events, robot.ctx.data, strict=True) if kind == "holder"
    ]
    why = robot.ctx.said("state")[-1].reason
    assert told == [
        ("console took the base", {"took": "console"}),
        (f"console lost the base: {why}", {"lost": "console", "why": why}),
    ]
    wording(why)


def attitude(robot, turned_deg=0.0, **more):
    now = robot.ctx.now
    robot.ctx.arrive(
        "attitude",
        AttitudeState(valid=True, epoch="e", measured_s=now, turned_deg=turned_deg, heading_deg=10.0, **more),
    )


def test_a_turn_and_a_heading_are_commands_like_any_other(robot):
    attitude(robot)
    begun = robot.send(robot.ctx.turn(90.0))
    assert (begun.answer.accepted, begun.answer.goal[:5]) == (True, "goal-")
    attitude(robot)
    robot.run(0.1, lambda: robot.send(robot.ctx.turn(90.0, lease=begun.answer.lease)))
    left, right = robot.wheels
    assert left == -right > 0.0
    assert robot.send(robot.ctx.head(5.0, lease=begun.answer.lease)).answer.accepted
    assert robot.ctx.said("state")[-1].angle_deg == -90.0
    assert [result.result for result in robot.ctx.said("result")] == ["superseded"]


def test_a_distance_is_driven_by_the_odometry(robot):
    message = OdometryState(valid=True, epoch="o", counted_s=robot.ctx.now, distance_m=3.0, speed_mps=0.0)
    robot.ctx.arrive("odometry", message)
    begun = robot.send(robot.ctx.command(0.5, distance_cm=100.0))
    assert begun.answer.goal
    robot.ctx.now += 0.25
    robot.run(0.2)
    assert robot.ctx.said("result")[-1].distance_m == 0.0


def test_a_check_is_asked_of_a_turn_too(robot):
    attitude(robot)
    robot.ctx.checks = {"cliff": CheckVerdict(accepted=False, reason="a cliff")}
    refused = robot.send(robot.ctx.turn(-20.0))
    assert refused.answer.reason == "check cliff: a cliff"
    (asked,) = robot.ctx.asked
    assert (asked.message.turn.angle_deg, asked.message.command.angle_deg) == (-20.0, -90.0)


def test_a_robot_without_rows_of_sensors_goes_by_a_ring():
    ctx = DriveContext()
    ctx.given = ()
    drive = KIND.load()(ctx)
    drive.open()
    assert drive._state.sensors.singles == ("forward", "back", "left", "right", "bottom")


def test_the_motors_hear_of_a_command_before_its_sender_does(robot, monkeypatch):
    robot.send(call := robot.ctx.command(0.5))
    robot.run(0.1)
    said, publish = [], robot.ctx.publish
    monkeypatch.setattr(
        robot.ctx, "publish", lambda output, *more, **named: (said.append(output), publish(output, *more))
    )
    changed = robot.ctx.command(0.2, lease=call.answer.lease)
    reply = changed.reply
    monkeypatch.setattr(changed, "reply", lambda *answer, **named: (said.append("answer"), reply(*answer, **named)))
    robot.send(changed)
    assert changed.answer.accepted
    assert said[:2] == ["setpoint", "answer"]
