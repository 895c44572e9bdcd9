"""A programme: every key frame at its place, in portions that a message holds."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.bus.wire import MAX_COMMAND_BYTES
from lbr.messages.joints import JointsCommand, JointsState, JointState, KeyFrame, Motion, PlayCommand
from lbr.operations.motions.pose import reach_s
from lbr.operations.motions.programme import programme
from tests.operations.motions.motions_bench import JOINTS, frame


def motion(name, count, **leads):
    return Motion(name=name, frames=tuple(frame(1.0, neck=index / 100) for index in range(count)), **leads)


@given(
    before=st.integers(0, 3),
    body=st.integers(1, 60),
    after=st.integers(0, 3),
    times=st.integers(1, 40),
    speed=st.floats(0.1, 3.0),
)
def test_the_portions_are_all_key_frames_in_order(before, body, after, times, speed):
    leads = {"lead_in": "before" if before else "", "lead_out": "after" if after else ""}
    motions = [motion("body", body, **leads), motion("before", before), motion("after", after)]
    wanted = programme(motions, PlayCommand(motion="body", times=times, speed=speed))
    found: list[KeyFrame] = []
    while len(found) < wanted.length:
        portion = wanted.portion(len(found))
        assert portion
        found += portion
    one_round = list(range(body))
    expected = [*range(before), *(one_round * times), *range(after)]
    assert [round(one.positions["neck"] * 100) for one in found] == expected
    assert all(one.duration_s == 1.0 / speed for one in found)
    rounds = [wanted.place(index).round for index in range(wanted.length + 1)]
    assert rounds == sorted(rounds)
    assert rounds[-1] == times


@given(st.integers(1, 253))
def test_a_portion_fits_into_a_command_however_many_joints_there_are(count):
    positions = {f"a_joint_with_as_long_a_name_as_there_is{index}": -0.1234567890123456 for index in range(count)}
    many = Motion(name="many", frames=(KeyFrame(positions=positions, duration_s=0.1),) * 60)
    portion = programme([many], PlayCommand(motion="many")).portion(0)
    assert len(msgspec.json.encode(JointsCommand(frames=portion))) < MAX_COMMAND_BYTES


@pytest.mark.parametrize(("mirror", "expected_s"), [(False, 0.5), (True, 1.0)])
def test_the_way_from_here_is_as_long_as_its_slowest_joint(mirror, expected_s):
    joints = tuple(msgspec.structs.replace(one, speed_rps=1.5) for one in JOINTS)
    states = {"right_elbow": JointState(id=5, position_rad=-0.5), "left_elbow": JointState(id=6, position_rad=0.0)}
    state = JointsState(sequence=1, measured_s=1.0, moving=False, phase="holding", joints=states)
    assert reach_s(joints, state, frame(right_elbow=-1.0, nobody=3.0), mirror=mirror) == pytest.approx(expected_s)
    assert reach_s(joints, state, frame(neck=1.0), mirror=mirror) == 0.0
