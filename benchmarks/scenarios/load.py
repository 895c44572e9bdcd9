"""B1, B2 and E1 with the machine idle, and under four busy loops that have nothing to do with the robot."""

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise

from benchmarks.bench import Bench, bench
from benchmarks.figures import Results
from benchmarks.scenarios import estop
from benchmarks.trace import Line

BUSY_LOOPS = 4
DRIVE_S = 10.0
PRESSES = 10


def loaded(results: Results, n: int) -> None:
    """Both conditions, `n` times: drive for ten seconds, then press ten times."""
    with bench(results) as under_test:
        for _ in range(n):
            steadiness(under_test, "I")
            with busy_loops():
                steadiness(under_test, "H")
                for _ in range(PRESSES):
                    estop.press(under_test, "E1 H", lambda: under_test.robot.line("estop"))


def steadiness(under_test: Bench, load: str, *, for_s: float = DRIVE_S) -> None:
    """Drive and measure the intervals between motor commands; whatever stops the robot meanwhile is counted."""
    mover = under_test.drive()
    since_ns = time.monotonic_ns()
    before = _unasked(under_test)
    under_test.pass_time(for_s)
    under_test.trace.read()
    mover.cease()
    lines = [line.at_ns for line in under_test.trace.lines(since_ns) if isinstance(line, Line)]
    for earlier, later in pairwise(lines):
        under_test.results.sample(f"B1 {load}", (later - earlier) * 1e-6)
    stops = _unasked(under_test) - before
    under_test.results.sample(f"B2 {load}", stops)
    under_test.pass_time(0.3)


def _unasked(under_test: Bench) -> int:
    """Count the driver's ends and trips so far."""
    events = under_test.robot.line("/report/events")["data"]
    return under_test.unit("motors")["restarts"] + sum(event["kind"] == "trip" for event in events)


@contextmanager
def busy_loops(n: int = BUSY_LOOPS) -> Iterator[None]:
    """Keep the machine busy, each loop in a session of its own, as somebody's programs would be."""
    loops = [subprocess.Popen([sys.executable, "-c", "while True: pass"], start_new_session=True) for _ in range(n)]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()
