"""The head of the simulated UXA-90 after a ball that its own camera sees: every process is the real one."""

import os
import signal

from tests.support import needs
from tests.support.robot import prepare, running
from tests.support.waiting import until

needs.modules("cv2")
NEEDED = ("world", "servos", "joints", "camera_head", "tracking")
EDITS = (
    f"UPDATE capability SET enabled = 0 WHERE robot = 'uxa90' AND name NOT IN {NEEDED}",
    """UPDATE capability SET settings = json_set(settings, '$.balls', json('{"ball": {"x_m": 1.5, "y_m": 0.3, "z_m": 0.55}}'))
    WHERE robot = 'uxa90' AND name = 'world'""",
)


LIMIT_S = 15.0


def seen(robot):
    """What the head sees while it follows; on a machine so busy that the lease lapsed it is told to go on."""
    state = robot.ask("tracking/state") or {}
    if not state.get("following"):
        robot.ask("tracking/track", {}, timeout_s=5.0)
    return state.get("seen")


def in_the_middle(robot):
    ball = seen(robot)
    return ball is not None and abs(ball["x"]) < 0.06 and abs(ball["y"]) < 0.06


def joints(robot):
    return until(lambda: robot.ask("joints/state"))["joints"]


def rests_at(robot):
    """The goal of the neck, if it was the same for several sweeps of the servos."""
    first = until(lambda: robot.ask("joints/state"))
    until(lambda: (robot.ask("joints/state") or first)["sequence"] > first["sequence"] + 5)
    goal = yaw_goal(robot)
    return [goal] if goal == first["joints"]["neck_yaw"]["goal_rad"] else []


def yaw_goal(robot):
    return joints(robot)["neck_yaw"]["goal_rad"]


def test_the_head_follows_a_ball_and_holds_when_tracking_is_killed_in_mid_move(home):
    prepare(home.parent / "u", edits=EDITS)
    with running(home.parent / "u", profile="uxa90-sim") as robot:
        until(lambda: in_the_middle(robot), what="the ball in the middle")
        assert yaw_goal(robot) > 0.1
        assert {name for name, joint in joints(robot).items() if joint["torque"]} == {"neck_yaw", "head_pitch"}
        robot.ask("world/ball", {"name": "ball", "y_m": -0.4})
        until(lambda: seen(robot) and yaw_goal(robot) < 0.1, what="the head on its way")
        os.kill(robot.capability("tracking")["pid"], signal.SIGKILL)
        until(lambda: robot.ask("joints/state", timeout_s=5.0).get("holder") is None, what="the end of the lease")
        (held,) = until(lambda: rests_at(robot), what="the neck at rest")
        until(lambda: robot.capability("tracking")["restarts"], what="its restart")
        state = until(lambda: robot.ask("tracking/state"), what="its state")
        assert not state["following"]
        assert yaw_goal(robot) == held
