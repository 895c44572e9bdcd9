"""The public state of the joints: each value of a servo in its joint's own sense, and a code for what is wrong."""

import msgspec
import pytest
from msgspec.structs import replace

from lbr.messages.joints import JointState
from lbr.messages.servos import ServosState, ServoState
from lbr.operations.joints.settings import JointsSettings
from lbr.operations.joints.state import State, first_state
from lbr.operations.joints.view import joints_state
from tests.operations.joints.joints_bench import BODY, START

NAME = "left_shoulder_pitch"
"""Its servo 2 turns the other way, and is at 1.5 rad where the joint is at 0."""
SERVO = ServoState(
    id=2,
    position_rad=2.000001,
    speed_rps=0.25,
    load=0.0,
    goal_rad=1.5,
    torque=0.5,
    voltage_v=11.9,
    temperature_c=40.0,
    faults=("warm",),
    raw=512,
    trusted=True,
    age_s=0.02,
)


def with_servo(servo: ServoState = SERVO) -> State:
    servos = ServosState(sweep=7, measured_s=START - 0.02, armed=True, phase="holding", servos=(servo,))
    known = replace(first_state(JointsSettings(), BODY), servos=servos, seen={NAME: servo}, servos_at=START)
    return replace(known, adopted=True, on=frozenset({NAME}))


def test_a_joint_is_its_servo_in_its_own_sense():
    state = joints_state(with_servo(), START + 0.01)
    turned = {"position_rad": -0.5, "speed_rps": -0.25, "load": 0.0, "goal_rad": 0.0, "age_s": 0.03}
    expected = JointState(**msgspec.structs.asdict(SERVO) | turned)
    assert msgspec.json.encode(state.joints[NAME]) == msgspec.json.encode(expected), "no zero is negative"
    said = (state.sequence, state.measured_s, state.moving, state.phase)
    assert said == (7, START - 0.02, False, "holding")
    assert (state.stopped_s, state.stopped_by, state.halted_s, state.halted_by) == (None, "", None, "")


def test_of_what_is_not_measured_nothing_is_told():
    found = joints_state(with_servo(ServoState(id=2)), START).joints[NAME]
    assert found == JointState(id=2)


@pytest.mark.parametrize(
    ("changes", "code"),
    [
        ({"reason": "it has no torque"}, "no_torque"),
        ({"reason": "it is hot", "latched": ("overheating",)}, "latched"),
        ({"reason": "it is silent", "position_rad": None, "raw": None}, "unreachable"),
        ({"reason": "its raw value is not believed", "position_rad": None}, "no_torque"),
        ({"position_rad": None, "raw": None}, ""),
    ],
)
def test_what_is_wrong_with_a_joint_has_a_code(changes, code):
    assert joints_state(with_servo(replace(SERVO, **changes)), START).joints[NAME].code == code


@pytest.mark.parametrize("lost", [False, True])
def test_servos_that_nobody_moves_let_go_in_the_end_if_their_mover_is_lost(lost):
    idle = with_servo().leases.reason.text
    said = joints_state(replace(with_servo(), lost=lost), START).reason
    assert said.startswith(idle)
    assert ("release slowly" in said) is lost
    assert "release slowly" not in joints_state(replace(with_servo(), lost=lost, on=frozenset()), START).reason
