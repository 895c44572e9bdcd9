"""A gamepad at the robot's own computer, from the pad's bytes to the motors': whatever is lost in between, the wheels stand."""

import os
import signal
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support.mover import Mover
from tests.support.robot import Robot, prepare, running
from tests.support.trace import Trace
from tests.support.waiting import STOPS_S, until

pytestmark = [pytest.mark.slow_start]
PAD = (
    "INSERT INTO device (robot, name, type, address) VALUES ('lbr', 'pad', 'gamepad', '/dev/input/by-id/usb-pad')",
    "INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'gamepad', 'gamepad', '{\"device\": \"pad\"}')",
    'UPDATE capability SET settings = \'{"turn_rps": 3, "lines": {"x": "/r/0.3/90"}}\' WHERE name = \'teleop\'',
    "UPDATE capability SET enabled = 1 WHERE robot = 'lbr' AND name = 'teleop'",
)
STILL_S = 0.8
TRIES = 4


@pytest.fixture(scope="module")
def robot() -> Iterator[Robot]:
    """A robot with a gamepad, which nobody touches."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place, running(prepare(Path(place) / "h", edits=PAD)) as started:
        yield started


@pytest.fixture
def trace(robot: Robot) -> Iterator[Trace]:
    """What the motors get; afterwards the hand is off the pad."""
    yield Trace(robot.trace)
    for name in ("unplug", "silent", "right_x", "pressed"):
        robot.line(f"/fault/pad/{name}/off")


def hand(robot: Robot, **done: Any) -> int:
    """Do this to the pad; return when."""
    at_ns = time.monotonic_ns()
    for name, value in done.items():
        assert robot.line(f"/fault/pad/{name}/{value}")["code"] == 0
    return at_ns


def hears(robot: Robot, **told: Any) -> None:
    """Wait until teleop says so of itself."""

    def look() -> bool:
        state = robot.ask("teleop/state") or {}
        return all(state.get(name) == value for name, value in told.items())

    until(look, what=f"teleop says {told}")


def spin(robot: Robot, trace: Trace) -> None:
    """Press the dead-man button anew, and turn; on a busy machine a lease may lapse, and it is to be done again."""
    for _ in range(TRIES):
        hand(robot, right_x=0, pressed="off")
        hears(robot, pad=True, dead_man=False)
        hand(robot, pressed="tl")
        hears(robot, dead_man=True)
        hand(robot, right_x=1)
        end = time.monotonic() + 2.0
        while time.monotonic() < end:
            if trace.now().least > 0.2:
                return
            time.sleep(0.01)
    raise AssertionError(f"it does not turn: {robot.ask('teleop/state')} {robot.ask('drive/state')}")


def stands(robot: Robot, trace: Trace) -> None:
    """Nothing moves for a while, whatever is held."""
    end = time.monotonic() + STILL_S
    while time.monotonic() < end:
        assert trace.now().zero, "the old motion goes on"
        time.sleep(0.01)


def kill(robot: Robot, name: str, number: signal.Signals) -> int:
    pid, at_ns = robot.capability(name)["pid"], time.monotonic_ns()
    os.kill(pid, number)
    return at_ns


def zero_ms(trace: Trace, since_ns: int) -> float:
    zero = trace.first_zero(since_ns, 2.0)
    assert zero is not None, "the wheels still turn after 2 s"
    return (zero.at_ns - since_ns) * 1e-6


def test_the_pad_turns_the_wheels_and_a_released_button_stops_them(robot, trace):
    spin(robot, trace)
    assert trace.now().left > 0.2 > -0.2 > trace.now().right
    assert zero_ms(trace, hand(robot, pressed="off")) < STOPS_S * 1000.0
    stands(robot, trace)


@pytest.mark.parametrize("what", ["unplug", "gamepad killed", "gamepad frozen", "teleop killed", "teleop frozen"])
def test_whatever_is_lost_in_motion_the_wheels_stand_and_nothing_resumes_before_the_button_is_pressed_anew(
    robot, trace, what, record_property
):
    spin(robot, trace)
    name, _, how = what.partition(" ")
    if not how:
        lost_ns = hand(robot, unplug=1)
    else:
        lost_ns = kill(robot, name, signal.SIGKILL if how == "killed" else signal.SIGSTOP)
    took_ms = zero_ms(trace, lost_ns)
    record_property("zero after ms", round(took_ms))
    if not how:
        hears(robot, pad=False, driving=False)
        reason = until(lambda: robot.capability("gamepad")["reason"], what="the loss is told")
        assert "pad" in reason
        hand(robot, unplug=0)
    hears(robot, pad=True, driving=False)
    stands(robot, trace)
    assert took_ms < STOPS_S * 1000.0
    spin(robot, trace)


@pytest.mark.parametrize("line", ["s", "estop"])
def test_a_stop_by_anybody_ends_it_until_the_button_is_pressed_anew(robot, trace, line):
    spin(robot, trace)
    at_ns = time.monotonic_ns()
    robot.line(line)
    assert zero_ms(trace, at_ns) < 1000.0
    if line == "estop":
        until(lambda: robot.line("reset")["code"] == 0, what="the emergency stop is released")
    stands(robot, trace)
    spin(robot, trace)


def test_the_pad_stops_what_anybody_drives(robot, trace):
    hears(robot, pad=True, dead_man=False)
    mover = Mover(robot, 90.0).start()
    try:
        until(lambda: not trace.now().zero, what="it drives")
        assert zero_ms(trace, hand(robot, pressed="b")) < STOPS_S * 1000.0
        assert "teleop" in until(lambda: robot.ask("drive/state")["stopped_by"], what="it is told who stopped it")
        stands(robot, trace)
    finally:
        mover.cease()


def test_a_line_that_moves_goes_on_while_the_button_is_held(robot, trace):
    hand(robot, pressed="tl")
    hears(robot, dead_man=True)
    hand(robot, pressed="tl,x")
    hears(robot, line="/r/0.3/90")
    until(lambda: trace.now().least > 0.2, what="the wheels turn")
    time.sleep(STILL_S)
    assert trace.now().least > 0.2
    assert zero_ms(trace, hand(robot, pressed="x")) < STOPS_S * 1000.0
    stands(robot, trace)
