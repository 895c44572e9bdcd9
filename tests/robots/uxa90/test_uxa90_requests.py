"""What requests to /motor, /multimotor and /motion want, and what goes to the joints for them."""

from math import radians

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.web.face import Refused
from lbr.robots.uxa90.rest.counts import allowed, count_of, joint_rad, strength
from tests.robots.uxa90.uxa90_bench import SHIPPED, Bench, joints_state
from tests.support.replies import dead

COUNT = radians(269 / 254)


@pytest.fixture
def bench() -> Bench:
    return Bench()


def refused(bench: Bench, query: str) -> tuple[int, str]:
    with pytest.raises(Refused) as caught:
        bench.motor(query)
    assert bench.sent() == []
    return caught.value.status, caught.value.message


def test_a_move_is_the_joints_with_its_strength_and_joins_others(bench):
    answer = bench.motor("id=23&position=100&torq=4")
    assert (answer.oldPosition, answer.newPosition, answer.torq) == (127, 100, 4)
    (command,) = bench.sent()
    assert command.positions == {"neck_yaw": pytest.approx(27 * COUNT)}
    assert (command.join, command.torque, command.lease) == (True, 0.2, "")


def test_the_second_move_quotes_the_lease_of_the_first(bench):
    bench.motor("id=23&pos=100")
    bench.motor("id=24&pos=110")
    assert [command.lease for command in bench.sent()] == ["", "lease-1"]


def test_the_lease_is_renewed_until_all_have_arrived_and_then_let_be(bench):
    bench.motor("id=23&pos=100")
    bench.run(1.0)
    renewals = [asked for asked in bench.ctx.asked if not asked.message.positions]
    assert 8 <= len(renewals) <= 11
    assert {asked.message.lease for asked in renewals} == {"lease-1"}
    bench.robot.moved = (bench.ended("goal-1"),)
    bench.run(1.0)
    assert len([asked for asked in bench.ctx.asked if not asked.message.positions]) == len(renewals)
    bench.motor("id=23&pos=120")
    assert bench.sent()[-1].lease == ""


def test_a_lease_that_died_just_then_is_asked_for_anew(bench):
    bench.motor("id=23&pos=100")
    bench.automatic = False
    promise = bench.asked_motor("id=24&pos=110")
    bench.ctx.asked[-1].reply(dead("reached in 0.30 s", "done"))
    bench.answered = len(bench.ctx.asked)
    bench.automatic = True
    bench.run()
    assert promise.result(0).newPosition == 110
    assert [command.lease for command in bench.sent()] == ["", "lease-1", ""]


def test_what_was_asked_for_before_a_stop_is_not_asked_for_anew_after_it(bench):
    bench.motor("id=23&pos=100")
    bench.automatic = False
    promise = bench.asked_motor("id=24&pos=110")
    bench.ctx.asked[-1].reply(dead("stopped by console", "stopped"))
    bench.answered = len(bench.ctx.asked)
    bench.automatic = True
    bench.run()
    with pytest.raises(Refused, match="stopped by console"):
        promise.result(0)
    assert len(bench.sent()) == 2
    bench.motor("id=24&pos=110")
    assert bench.sent()[-1].lease == ""


def test_what_was_asked_for_before_a_motion_is_not_asked_for_anew_during_it(bench):
    bench.motor("id=23&pos=100")
    bench.automatic = False
    promise = bench.asked_motor("id=24&pos=110")
    late = bench.ctx.asked[-1]
    bench.answered = len(bench.ctx.asked)
    bench.automatic = True
    bench.play("4")
    late.reply(dead("reached in 0.30 s", "done"))
    bench.run()
    with pytest.raises(Refused):
        promise.result(0)
    assert len(bench.sent()) == 2


def test_a_refused_move_says_why_and_is_not_remembered(bench):
    bench.refusal = "held by tracking"
    with pytest.raises(Refused, match="held by tracking") as caught:
        bench.motor("id=23&pos=100")
    assert caught.value.status == 409
    bench.refusal = ""
    assert bench.motor("id=23").data.position == 127


def test_a_refused_move_leaves_the_others_alone(bench):
    bench.motor("id=23&pos=100")
    bench.refusal = "left_knee has latched an overload"
    with pytest.raises(Refused):
        bench.motor("id=5&pos=100")
    bench.refusal = ""
    bench.motor("id=24&pos=110")
    assert bench.sent()[-1].lease == "lease-1"
    assert bench.sent("halt") == []


@pytest.mark.parametrize(
    ("query", "status", "message"),
    [
        ("id=20", 409, "Motor '20' doesn't exist"),
        ("id=abc", 409, "Motor 'NaN' doesn't exist"),
        ("id=1&id=2", 409, "Motor 'NaN' doesn't exist"),
        ("id=23.5&pos=1", 409, "Motor '23.5' doesn't exist"),
        ("id=1e30", 409, "Motor '1e+30' doesn't exist"),
        ("id=-Infinity", 409, "Motor '-Infinity' doesn't exist"),
        ("id=23&torq=2", 400, "torq is of no use"),
        ("id=23&torque=", 400, "torq is of no use"),
        ("id=23&pos=abc", 400, "pos must be a number"),
        ("id=23&pos=NaN", 400, "pos must be a number"),
        ("id=23&pos=1&torq=strong", 400, "torq must be a number"),
        ("id=23&pos=1&pos=2", 400, "pos was given 2 times"),
        ("id=23&pos=1&torque=2&torque=3", 400, "torque was given 2 times"),
        ("id=23&pos=1&unit=turns", 400, "unit 'turns'"),
        ("id=23&pos=1&delay=-1", 400, "delay is milliseconds"),
        ("id=23&pos=1&delay=600001", 400, "delay is milliseconds"),
        ("id=23&pos=1&delay=soon", 400, "delay is milliseconds"),
        ("id=4&pos=204", 409, "204 is beyond what left_knee may do"),
        ("id=6&pos=255", 409, "255 is not a position of a servo"),
        ("id=6&pos=0", 409, "0 is not a position of a servo"),
    ],
)
def test_what_is_refused_moves_nothing(bench, query, status, message):
    got, said = refused(bench, query)
    assert got == status
    assert message in said


@pytest.mark.parametrize(
    ("query", "position", "torq"),
    [
        ("id=23&pos=100", 100, 0), ("id=0x17&pos=1e2", 100, 0), ("id=23.0&pos=%20100", None, 0),
        ("id=23&pos=Infinity", 254, 0), ("id=23&pos=-Infinity", 1, 0), ("id=23&pos=0", 1, 0), ("id=23&pos=255", 254, 0),
        ("id=23&pos=&position=90", 90, 0), ("id=23&position=", 1, 0), ("id=23&pos=5&position=200", 5, 0),
        ("id=23&pos=100.5&torq=1.5", 100.5, 1.5), ("id=23&pos=9&torq=5", 9, 4), ("id=23&pos=9&torq=7", 9, 4),
        ("id=23&pos=9&torq=&torque=3", 9, 3), ("id=23&pos=9&torque=", 9, 0), ("id=24&pos=300&torque=9", 160, 4),
    ],
)  # fmt: skip
def test_numbers_are_read_as_they_always_were(bench, query, position, torq):
    if position is None:
        assert refused(bench, query)[0] == 400
        return
    answer = bench.motor(query)
    assert (answer.newPosition, answer.torq) == (position, torq)


def test_fractions_are_echoed_and_rounded_for_the_servo(bench):
    answer = bench.motor("id=23&pos=100.5&torq=1.5")
    assert answer.data.position == 100.5
    (command,) = bench.sent()
    assert command.positions["neck_yaw"] == pytest.approx(26 * COUNT)
    assert command.torque == strength(2)


@given(
    st.dictionaries(
        st.sampled_from(["id", "pos", "position", "torq", "torque", "unit", "delay"]),
        st.lists(st.text(max_size=6) | st.integers(-5, 300).map(str), min_size=1, max_size=2),
    )
)
def test_any_query_is_answered_and_what_moves_is_legal(query):
    bench = Bench()
    status = 200
    try:
        promise = bench.begin(bench.work.motor(query, lambda role: None, measured=False))
        bench.run()
        msgspec.json.encode(promise.result(0))
    except Refused as err:
        status = err.status
    assert status in {200, 400, 409}
    rows = {joint.name: joint for joint in SHIPPED.joints}
    for command in bench.sent():
        for name, angle_rad in command.positions.items():
            assert rows[name].lower_rad - 1e-3 <= angle_rad <= rows[name].upper_rad + 1e-3
            assert 1 <= round(count_of(rows[name], angle_rad)) <= 254
        assert command.torque in {1.0, 0.8, 0.6, 0.4, 0.2}


@pytest.mark.parametrize("joint", SHIPPED.joints, ids=lambda joint: joint.name)
def test_counts_become_angles_and_again_counts(joint):
    lowest, highest = allowed(joint)
    for count in range(lowest, highest + 1):
        angle_rad = joint_rad(joint, count)
        assert joint.lower_rad - 1e-9 <= angle_rad <= joint.upper_rad + 1e-9 or count in {lowest, highest}
        assert count_of(joint, angle_rad) == pytest.approx(count)


def test_units_are_percent_of_the_range_or_degrees_of_the_joint(bench):
    answer = bench.motor("id=24&pos=50&unit=percent")
    assert (answer.newPosition, answer.data.smartPosition, answer.data.rawPosition) == (130, 50, 130)
    assert bench.motor("id=18&pos=100&unit=percent").newPosition == 75  # counts from its highest position down
    answer = bench.motor("id=23&pos=28.6&unit=deg")
    assert (answer.newPosition, answer.data.smartPosition) == (100, 28.6)
    assert bench.motor("id=23&unit=raw").data.smartPosition == 100
    assert bench.motor("id=23").data.smartPosition is msgspec.UNSET


def test_what_is_measured_comes_only_when_asked_for(bench):
    bench.say(joints_state())
    assert b"measured" not in msgspec.json.encode(bench.motor("id=23"))
    neck = bench.motor("id=23", measured=True).data
    assert (neck.measured.position, neck.measured.load, neck.measured.trusted, neck.commanded) == (100, 0.1, True, 127)
    head = bench.motor("id=24", measured=True).data
    assert (head.measured.position, head.measured.trusted) == (None, False)
    assert bench.motor("id=0", measured=True).data.measured is None


def test_several_motors_of_one_strength_are_one_command(bench):
    answer = bench.several(*({"id": number, "pos": 127} for number in (0, 1, 2, 3, 10, 11, 16, 17, 22, 23, 24)))
    assert all(item["torq"] == 0 for item in answer.multiMsg.positions)
    (command,) = bench.sent()
    assert len(command.positions) == 11


def test_several_strengths_are_one_command_too_so_that_all_begin_or_none(bench):
    bench.several({"id": 23, "pos": 20, "torq": 0}, {"id": 24, "pos": 120, "torq": 3}, {"id": 0, "pos": 130, "torq": 3})
    (command,) = bench.sent()
    assert command.torques == {"neck_yaw": 1.0, "head_pitch": 0.4, "left_ankle_roll": 0.4}
    assert command.positions.keys() == command.torques.keys()


def test_what_is_sent_is_echoed_clamped_in_its_place(bench):
    answer = bench.several(
        {"id": 24, "pos": 200, "torq": 9, "note": {"x": 1}},
        {"position": 5, "toqr": 1, "id": 23},
        {"id": 0, "pos": 130, "torque": 2},
    )
    assert answer.multiMsg.positions == [
        {"id": 24, "pos": 160, "torq": 4, "note": {"x": 1}},
        {"position": 5, "toqr": 1, "id": 23},
        {"id": 0, "pos": 130, "torque": 2},
    ]
    assert bench.motor("id=24").data.position == 160
    assert list(answer.multiMsg.positions[1]) == ["position", "toqr", "id"]


def test_of_two_turns_of_a_motor_the_last_counts(bench):
    bench.several({"id": 23, "pos": 20}, {"id": 23, "pos": 220, "torq": 4})
    (command,) = bench.sent()
    assert command.positions["neck_yaw"] == pytest.approx(-93 * COUNT)
    assert bench.motor("id=23").data.position == 220


@pytest.mark.parametrize(
    ("items", "status"),
    [
        ([{"id": 23, "pos": 20}, {"id": 99, "pos": 1}, {"id": 24, "pos": 120}], 409),
        ([{"id": 23, "pos": 20}, {"id": "24", "pos": 1}], 409),
        ([{"id": 23, "pos": 20}, {"pos": 1}], 409),
        ([{"id": 23, "pos": 20}, {"id": True, "pos": 1}], 409),
        ([{"id": 23, "pos": 20}, {"id": 24}], 400),
        ([{"id": 23, "pos": 20}, {"id": 24, "pos": "120"}], 400),
        ([{"id": 23, "pos": 20}, {"id": 24, "pos": None}], 400),
        ([{"id": 23, "pos": 20}, {"id": 24, "pos": 120, "torq": []}], 400),
        ([{"id": 23, "pos": 20}, {"id": 24, "pos": 120, "delay": 1e9}], 400),
        ([{"id": 23, "pos": 20}, 24], 400),
        ([{"id": 23, "pos": 20}, {"id": 4, "pos": 204}], 409),
        ([{"id": 23, "pos": 20}] * 201, 400),
    ],
)
def test_if_one_of_several_is_wrong_nothing_moves(bench, items, status):
    with pytest.raises(Refused) as caught:
        bench.several(*items)
    assert caught.value.status == status
    assert bench.sent() == []
    assert bench.motor("id=23").data.position == 127


@pytest.mark.parametrize("body", [None, [], {}, {"motors": None}, {"motors": {}}, {"motors": "23"}, 7, "x"])
def test_a_body_that_is_no_list_of_motors_is_told(bench, body):
    with pytest.raises(Refused) as caught:
        bench.begin(bench.work.several(body, {})).result(0)
    assert caught.value.status == 400


@pytest.mark.parametrize("number", [10**400, -(10**400), 10**30, 1e300, 23.5], ids=range(5))
def test_numbers_of_any_size_are_read(bench, number):
    with pytest.raises(Refused) as caught:
        bench.several({"id": number, "pos": 1})
    assert caught.value.status == 409
    assert bench.several({"id": 24, "pos": abs(number), "torq": -abs(number)}).multiMsg.positions[0]["torq"] == 0
    with pytest.raises(Refused) as caught:
        bench.several({"id": 24, "pos": 1, "delay": -abs(number)})
    assert caught.value.status == 400
    for unit in ("percent", "deg"):
        assert bench.several({"id": 24, "pos": number, "unit": unit}, unit=unit).multiMsg.positions


def test_whoever_may_only_look_moves_nothing(bench):
    def refuse(role):
        raise Refused(403, f"this needs the role '{role}'")

    with pytest.raises(Refused, match="operate"):
        bench.begin(bench.work.motor(bench.query("id=23&pos=1"), refuse, measured=False)).result(0)
    shown = bench.begin(bench.work.motor(bench.query("id=23"), refuse, measured=False))
    assert shown.result(0).data.position == 127
    assert bench.sent() == []


def test_no_motors_move_nothing(bench):
    assert bench.several().multiMsg.positions == []
    assert bench.sent() == []
