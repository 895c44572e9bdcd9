"""What else the machine may be doing: busy loops beside the robot (H), and floods on its bus too (G).

The stops of S1, S3, S6, S8 and E1 are measured again under each, and how steady the motor commands are (B1, B2).
"""

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from itertools import pairwise

from tests.scenarios import clients, estop, kills
from tests.support import programs
from tests.support.bench import Bench, bench
from tests.support.clients import flood
from tests.support.figures import Results
from tests.support.robot import Robot
from tests.support.trace import Line

BUSY_LOOPS = 4
FLOODED = ("bench/telemetry", "motors/setpoint", "drive/nothing")
FLOOD_MESSAGES = 20_000
DRIVE_S = 10.0
PAUSE_S = 0.3
DEATHS = 3


def steady(results: Results, n: int) -> None:
    """B1 and B2, `n` times ten seconds idle and as long under busy loops."""
    with bench(results) as under_test:
        for _ in range(n):
            steadiness(under_test, "I")
            with busy_loops():
                steadiness(under_test, "H")


def stops_under(load: str) -> Callable[[Results, int], None]:
    """Return a scenario of all these stops under a load; each way once, `n` times."""

    def run(results: Results, n: int) -> None:
        loaded = results.under(load)
        with bench(loaded) as under_test, LOADS[load](under_test.robot):
            for turn in range(n):
                if turn and turn % DEATHS == 0:
                    under_test.forget_deaths("motors")
                    under_test.forget_deaths("drive")
                _stops(under_test)
        for _ in range(max(1, n // 3)):
            with bench(loaded) as under_test, LOADS[load](under_test.robot):
                kills.executive_killed(under_test)

    return run


def steadiness(under_test: Bench, load: str, *, for_s: float = DRIVE_S) -> None:
    """Drive and measure the intervals between motor commands; whatever stops the robot meanwhile is counted."""
    mover = under_test.drive()
    since_ns = time.monotonic_ns()
    before = _unasked(under_test)
    under_test.pass_time(for_s)
    for interval_ms in intervals_ms(under_test, since_ns):
        under_test.results.sample(f"B1 {load}", interval_ms)
    mover.cease()
    under_test.results.sample(f"B2 {load}", _unasked(under_test) - before)
    under_test.pass_time(PAUSE_S)


def intervals_ms(under_test: Bench, since_ns: int) -> list[float]:
    """Return the intervals between the motor commands that the controller has heard since."""
    under_test.trace.read()
    lines = [line.at_ns for line in under_test.trace.lines(since_ns) if isinstance(line, Line)]
    return [(later - earlier) * 1e-6 for earlier, later in pairwise(lines)]


@contextmanager
def busy_loops(n: int = BUSY_LOOPS) -> Iterator[None]:
    """Keep the machine busy, each loop in a session of its own, as somebody's programs would be."""
    loops = [programs.start([sys.executable, "-c", "while True: pass"], start_new_session=True) for _ in range(n)]
    try:
        yield
    finally:
        _end(loops)


@contextmanager
def floods(robot: Robot, keys: tuple[str, ...] = FLOODED, *payload: str, each: int = 0) -> Iterator[None]:
    """Let plain clients publish 20,000 messages at once, again and again: telemetry, forged setpoints, rubbish.

    `each` is how many messages each of them publishes at once instead.
    """
    share = each or FLOOD_MESSAGES // len(keys)
    program = [sys.executable, flood.__file__, robot.endpoints[0]]
    popens = [
        programs.start(
            [*program, f"{robot.name}/{key}", str(share), *payload],
            stdout=subprocess.PIPE,
            start_new_session=True,
            text=True,
        )
        for key in keys
    ]
    try:
        for popen in popens:
            assert popen.stdout is not None
            assert popen.stdout.readline().strip() == "flooding"
        yield
    finally:
        _end(popens)


@contextmanager
def _hogs(_robot: Robot) -> Iterator[None]:
    with busy_loops():
        yield


@contextmanager
def _hogs_and_floods(robot: Robot) -> Iterator[None]:
    with ExitStack() as stack:
        stack.enter_context(busy_loops())
        stack.enter_context(floods(robot))
        yield


LOADS = {"H": _hogs, "G": _hogs_and_floods}


def _stops(under_test: Bench) -> None:
    under_test.all_ready(10.0)
    kills.kill_process(under_test, "motors", "S1")
    under_test.all_ready(10.0)
    kills.kill_process(under_test, "drive", "S3")
    under_test.all_ready(10.0)
    for way in (clients.plain_client_killed, clients.send_killed, estop.by_console, estop.by_put):
        under_test.once_it_moves(way)


def _unasked(under_test: Bench) -> int:
    """Count the driver's ends and trips so far."""
    events = under_test.robot.line("/report/events")["data"]
    return under_test.unit("motors")["restarts"] + sum(event["kind"] == "trip" for event in events)


def _end(popens: "list[subprocess.Popen[str]] | list[subprocess.Popen[bytes]]") -> None:
    for popen in popens:
        popen.kill()
        popen.communicate()
