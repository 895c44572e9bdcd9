"""Two consoles of a real robot: what one has written ahead does not move it once the other has stopped it."""

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

import pytest

from lbr.bus import stamp, wire
from lbr.messages.leases import STOPPED_SINCE
from tests.support import programs
from tests.support import robot as robots
from tests.support.clients.terminal import OnTerminal
from tests.support.robot import LBR, environment
from tests.support.trace import Trace
from tests.support.waiting import HANG_S, until

TURN, BOUNDED, ON = "/r/0.4/90", "/r/0.4/90/0/forward/20", "/r/0.3/270"
PATIENT_CONSOLE = """
import sys
from lbr.console import ear, operator
from lbr.start import main
ear.FRESH_S = operator.LATE_ANSWER_S = 30.0
sys.argv = ["lbr", "console"]
sys.exit(main())
"""
"""A console that holds its motion although a busy machine holds it up, for as long as the lease lasts."""
BEGINS_S = 8.0
TYPED_BEFORE_S = 0.5
"""How long before the stop a line was typed: longer than the way of either."""


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    with robots.running(robots.prepare(tmp_path_factory.mktemp("h"), edits=robots.PATIENT)) as robot:
        yield robot


@contextmanager
def terminal(home, command="console") -> Iterator[OnTerminal]:
    on = OnTerminal(home, [*LBR, command])
    try:
        on.wait_for(b"Robot>")
        yield on
    finally:
        on.end()


def begun(robot, trace, lines: tuple[str, ...]) -> "subprocess.Popen[str] | None":
    """Say lines by a console of their own; None if the first moves nothing, because a busy machine held it up."""
    popen = programs.start(
        [sys.executable, "-c", PATIENT_CONSOLE],
        env=environment(robot.home),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    popen.stdin.write("".join(f"{line}\n" for line in lines))
    popen.stdin.flush()
    with suppress(AssertionError):
        until(lambda: trace.now().least >= 0.25, limit_s=BEGINS_S)
        return popen
    popen.kill()
    popen.communicate()
    return None


@contextmanager
def script(robot, trace, *lines: str, then: tuple[str, ...] = ()) -> "Iterator[subprocess.Popen[str]]":
    """Say lines of which the first moves the robot, and more once it does: else a stop may overtake the motion."""
    popen = until(lambda: begun(robot, trace, lines), what="motion")
    try:
        popen.stdin.write("".join(f"{line}\n" for line in then))
        popen.stdin.close()
        popen.stdin = None
        yield popen
    finally:
        popen.kill()
        popen.communicate()


def goes_on(robot, trace, *lines: str, then: tuple[str, ...]) -> None:
    """Say a script that comes to its good end; one whose motion a busy machine has ended is said again."""

    def said() -> bool:
        with script(robot, trace, *lines, then=then) as ours:
            _, err = ours.communicate(timeout=HANG_S)
        assert STOPPED_SINCE not in err
        return (ours.returncode, err) == (0, "")

    until(said, what="its good end")


def moving(trace) -> None:
    until(lambda: trace.now().least >= 0.25, what="motion")


def at_rest(trace) -> None:
    until(lambda: trace.now().zero, what="rest")


@pytest.mark.parametrize("stop", ["s", "estop"])
def test_a_script_ends_at_a_stop_by_another(robot, trace, stop):
    with terminal(robot.home) as theirs, script(robot, trace, BOUNDED, ON, "/report/health", "clock", ON) as ours:
        theirs.type(f"{stop}\r".encode())
        at_rest(trace)
        if stop == "estop":
            answers = (b"acknowledged", b"waiting for ")
            until(lambda: any(one in theirs.said for one in answers), what="the line's own press, after the key's")
            until(lambda: robot.line("reset")["code"] == 0, what="it is released")
        since_ns = time.monotonic_ns()
        out, err = ours.communicate(timeout=8)
        assert ours.returncode == 1
        trace.read()
        assert all(output.zero for output in trace.outputs(since_ns))
    if stop == "s":
        assert STOPPED_SINCE in err
    assert time.strftime("%Y") in out, "what only looks or tells the time is refused for no stop"


def test_a_script_that_stops_the_robot_itself_goes_on(robot, trace):
    goes_on(robot, trace, BOUNDED, then=("s", "/r/0.3/270/0/forward/1"))


@pytest.mark.parametrize("key", ["drive/stop", "@estop"])
def test_neither_a_line_that_waited_moves_after_a_stop_past_the_executive_nor_what_is_passed_on_for_it(
    robot, trace, key
):
    typed_s = time.monotonic() - TYPED_BEFORE_S
    if key == "@estop":
        robot.put("@estop", {"engaged": True, "reason": "a ladder"}, source="a page")
        until(lambda: robot.ask("drive/state")["estop"], what="the drive hears of it")
        until(lambda: robot.line("reset")["code"] == 0, what="it is released")
    else:
        assert robot.ask("drive/stop", {"whole": True}, source="a page")["accepted"]

    def passed_on(written_s: float) -> dict:
        origin = stamp.Origin("us", written_s)
        (answer,) = wire.ask(
            robot.bus, "lbr/drive/command", {"power": 0.3, "angle_deg": 270}, source="dance", origin=origin
        )
        return json.loads(answer.payload)

    in_time(lambda: waiting(robot, ON, typed_s), "reason_code", "stopped_since")
    in_time(lambda: passed_on(typed_s), "code", "stopped_since")
    in_time(lambda: passed_on(time.monotonic()), "accepted", True)


def test_a_script_releases_what_it_has_pressed_and_nothing_that_another_has(robot, trace):
    goes_on(robot, trace, "/r/0.3/90", then=("estop", "reset", "/r/0.3/270/0/forward/1", "status"))
    typed_s = time.monotonic() - TYPED_BEFORE_S
    waiting(robot, "estop", time.monotonic())
    until(lambda: robot.ask("@estop")["engaged"], what="its latch")
    robot.put("@estop", {"engaged": True, "reason": "a ladder"}, source="a page")
    until(lambda: after(waiting(robot, "reset", typed_s)), what="it is not released")
    assert robot.ask("@estop")["engaged"]
    until(lambda: waiting(robot, "reset", time.monotonic())["code"] == 0, what="it is released")


def waiting(robot, line: str, typed_s: float) -> dict:
    (answer,) = wire.ask(
        robot.bus, "lbr/@console", line, source="us", waited_s=time.monotonic() - typed_s, timeout_s=5.0
    )
    return json.loads(answer.payload)


def in_time(say: Callable[[], dict], field: str, value: object) -> None:
    """Check a field of the answer to what came in time; what a busy machine held up is said again."""
    answer = until(lambda: None if "late" in {(said := say()).get("code"), said.get("reason_code")} else said)
    assert answer[field] == value, answer


def after(result: dict) -> dict | None:
    """Return a refusal for a stop; how it came to be known may take a moment."""
    return result if result["reason_code"] == "stopped_since" else None


def test_lines_typed_ahead_do_not_move_what_another_console_stopped(tmp_path):
    home = robots.prepare(tmp_path, edits=robots.PATIENT)
    with terminal(home, "run") as ours, terminal(home) as theirs:
        trace = Trace(home / "trace.txt")
        until(lambda: '"ready":true' in robots.lbr(home, "status", "--json").stdout, what="its ranges, too")
        theirs.type(f"{TURN}\r".encode())
        moving(trace)
        for _ in range(5):
            ours.type(b"!__import__('time').sleep(2)\r")
        ours.type(f"{ON}\r".encode())
        ours.type(b"clock\r")
        until(lambda: ours.said.count(b"sleep(2)") >= 2)
        theirs.type(b"s\r")
        at_rest(trace)
        since_ns = time.monotonic_ns()
        ours.wait_for(STOPPED_SINCE.encode())
        ours.wait_for(time.strftime("%Y").encode())
        trace.read()
        assert all(output.zero for output in trace.outputs(since_ns))
