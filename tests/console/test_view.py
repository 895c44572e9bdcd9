from fake_robot import ROBOT, wait_for

from lbr.bus import wire
from lbr.commands.view import _frames
from lbr.messages.simulation import WorldBox, WorldPose, WorldScene

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
    assert not any("no news" in line for line in wait_for(lambda: say() and frame(80, 24)))
    now[0] += 12.0
    assert frame(80, 24)[0] == "no news for 12 s; is the robot gone?"
    assert len(frame(80, 24)) <= 24
    assert len(frame(20, 24)[0]) == 20
    wait_for(lambda: say() and "no news" not in frame(80, 24)[0])


MESSAGES = (("scene", SCENE), ("pose", POSE))
