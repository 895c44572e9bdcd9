"""Teleoperation by the whole robot, a hand at the leader; every loss is judged at the follower's bus."""

import os
import signal
import time
from statistics import median

import pytest
from robots import arms, setting, until

pytestmark = pytest.mark.timeout(220)
HOLD_S, RELEASE_S = 1.0, 1.0
PATIENT = (
    setting("arm", hold_s=HOLD_S, release_s=RELEASE_S, setpoint_valid_s=0.25),
    setting("joints", ttl_s=1.0),
    setting("teleop", max_age_s=1.0),
)
"""A busy machine may delay any process for some tenths of a second; these tests judge the time after that."""


@pytest.fixture(scope="module")
def robot():
    """One robot for all tests: each begins by giving the follower torque, and by a new teleoperation."""
    with arms(*PATIENT) as found:
        yield found


def near(robot):
    return abs(robot.at("shoulder_pan") - robot.at("leader_shoulder_pan", "leader_joints")) < 0.08


def let_go(robot, lost):
    """Judge at the bus: the servos soon stand, with torque; that fades, and is off, and not too soon."""
    until(lambda: robot.state("arm")["phase"] != "following", "the follower holds", 8.0)
    at = robot.servos()[1]["position_rad"]
    until(lambda: not any(robot.torques()), "the follower without torque")
    off = time.monotonic()
    assert off - lost > HOLD_S + RELEASE_S - 0.3, "it was not held first"
    assert robot.servos()[1]["position_rad"] == pytest.approx(at, abs=0.15)


def begun(robot, degrees):
    robot.torque_on()
    robot.follow(lambda: robot.phase() == "following", "the follower follows")
    robot.say(f"/hand/leader_shoulder_pan/{degrees}")
    start = robot.at("shoulder_pan")
    robot.follow(lambda: abs(robot.at("shoulder_pan") - start) > 0.1, "the follower moves")


def stopped(robot):
    """Stop it while it follows, and return why it ended: on a busy machine, possibly for an earlier reason."""
    robot.follow(lambda: robot.phase() == "following", "it follows")
    robot.say("s")
    return robot.teleop("idle")["code"]


def test_the_follower_goes_with_the_leader_and_ends_with_it(robot, capsys):
    until(lambda: "have no torque" in robot.hear("teleop")["text"], "a follower without torque is refused")
    robot.torque_on()
    robot.say("/hand/leader_shoulder_pan/-60")
    until(lambda: robot.at("leader_shoulder_pan", "leader_joints") < -1.0, "the hand")
    robot.torque_on()
    robot.follow(lambda: robot.phase() == "approaching", "it approaches")
    robot.follow(lambda: near(robot), "the follower is with the leader")
    robot.follow(lambda: robot.phase() == "following", "it follows")

    windows, gaps, end = {}, [], time.monotonic() + 4.0
    robot.say("/hand/leader_shoulder_pan/60")
    while time.monotonic() < end or not gaps:
        robot.follow(lambda: robot.phase() != "idle", "it goes on")
        state = robot.state("teleop")
        gaps += [state["gap_rad"]] if state.get("gap_rad") is not None else []
        if state.get("loop"):
            windows[tuple(state["loop"].values())] = state["loop"]
        time.sleep(0.05)
    robot.follow(lambda: near(robot), "the follower came along")
    rates = sorted(one["rate_hz"] for one in windows.values())
    worst = sorted(one["period_max_ms"] for one in windows.values())
    with capsys.disabled():
        print(
            f"\nteleop: {robot.state('teleop')['sent']} commands sent; in {len(windows)} windows of 1 s {median(rates):.1f}/s "
            f"(p50), {rates[0]:.1f}/s (least), the longest gap {median(worst):.0f} ms (p50), {worst[-1]:.0f} ms "
            f"(max); joints {median(gaps):.3f} rad behind (p50), {max(gaps):.3f} (max)"
        )

    until(lambda: stopped(robot) in {"stopped", "not_following"}, "it ends with a stop")
    assert all(robot.torques()), "a stop holds"

    begun(robot, -60)
    robot.fault("leader_bus", "unplug", value=True)
    lost = time.monotonic()
    assert robot.teleop("idle")["code"] == "stale_sensor"
    let_go(robot, lost)
    robot.fault("leader_bus", "unplug", value=False)
    until(lambda: robot.measured("leader_arm"), "the leader again")

    begun(robot, 60)
    robot.say("estop")
    assert robot.teleop("idle")["code"] == "estop"
    until(lambda: robot.state("arm")["phase"] == "holding", "the follower holds")
    assert all(robot.torques())
    robot.say("reset")


@pytest.mark.parametrize(("end", "degrees"), [(signal.SIGKILL, 100), (signal.SIGSTOP, -60)], ids=["killed", "frozen"])
def test_a_teleoperation_that_dies_leaves_a_follower_that_holds_and_is_let_go(robot, end, degrees):
    begun(robot, degrees)
    os.kill(robot.pid("teleop"), end)
    let_go(robot, time.monotonic())
