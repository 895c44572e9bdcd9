from lbr.bus import wire
from lbr.messages.joints import JointsState, JointState
from lbr.simulation.commands.view import _frames
from lbr.simulation.messages import HumanoidPose, WorldBox, WorldPose, WorldScene
from tests.console.fake_robot import ROBOT
from tests.support.waiting import until

WALL = WorldBox(name="wall", x_m=2.0, y_m=0.0, length_m=0.1, width_m=4.0)
SCENE = WorldScene(walls=(WALL,), robot_length_m=0.6, robot_width_m=0.5)
POSE = WorldPose(
    x_m=0.0, y_m=0.0, yaw_rad=0.0, speed_mps=0.0, turn_rps=0.0, left=0.0, right=0.0, touching=False, battery_v=12.0,
    time_s=1.0,
)  # fmt: skip


def test_a_view_without_news_says_so_until_news_come(robot, client):
    now = [100.0]
    frame = _frames(client, ROBOT, lambda: now[0])
    assert frame(80, 24) == []
    say = lambda: [wire.put(robot.bus, f"{ROBOT}/world/{name}", what, source="world") for name, what in MESSAGES]  # noqa: E731
    assert not any("no news" in line for line in until(lambda: say() and frame(80, 24)))

    def silent() -> bool:
        now[0] += 12.0  # once more where the last message was still on its way
        return frame(80, 24)[0] == "no news for 12 s; is the robot gone?"

    until(silent, what="that nothing comes")
    assert len(frame(80, 24)) <= 24
    assert len(frame(20, 24)[0]) == 20
    until(lambda: say() and "no news" not in frame(80, 24)[0])


JOINTS = JointsState(
    sequence=1, measured_s=1.0, moving=False, phase="following", reason="stopped by phone", joints={
        "left_knee": JointState(id=14, position_rad=-0.5, goal_rad=-0.6, load=0.25, temperature_c=41.0, voltage_v=11.2),
        "right_knee": JointState(id=13, latched=("overload",), reason="silent"),
    },
)  # fmt: skip
LIES = HumanoidPose(
    x_m=0.0, y_m=0.0, z_m=0.29, roll_rad=0.0, pitch_rad=-0.1, yaw_rad=0.0, upright=True, held=False,
    on_floor=("left_foot", "right_foot"), joints={}, supply_v=11.9, time_s=1.0,
)  # fmt: skip


def test_a_humanoid_is_seen_joint_by_joint(robot, client):
    frame = _frames(client, ROBOT)
    messages = (("joints/state", JOINTS), ("world/pose", LIES))
    say = lambda: [wire.put(robot.bus, f"{ROBOT}/{key}", what, source="x") for key, what in messages]  # noqa: E731
    seen = until(lambda: say() and len(lines := frame(120, 24)) == 5 and lines)
    assert seen == [
        "upright, trunk 29 cm high, roll +0, pitch -6 degrees; on the floor: left_foot, right_foot",
        "following: stopped by phone",
        "joint                    angle    goal   load   °C     V  ",
        "left_knee                -28.6   -34.4   25 %   41  11.2  torque unknown",
        "right_knee                   -       -      -    -     -  latched: overload",
    ]
    assert max(len(line) for line in frame(20, 3)) == 20
    assert len(frame(20, 3)) == 3


MESSAGES = (("scene", SCENE), ("pose", POSE))
