"""P2: programs that crash at once, again and again: backed off, given up with a reason, and nobody else notices."""

import json
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import psutil

from tests.scenarios.load import intervals_ms
from tests.support.bench import Bench, bench
from tests.support.figures import Results, percentile

DELAYS_S = (0.1, 0.2, 0.4, 0.8, 1.6)
JITTER, LATE_S = 0.2, 2.5
WINDOW_S = 30.0
GIVES_UP_S = 12.0
BEFORE_S = 4.0
CRASHES = "date +%s.%N >> {file}; exit 3"
NEW_ROW = (
    "INSERT INTO capability (robot, name, kind, settings, help) VALUES ('lbr', 'crasher', 'exec', ?, 'Ends at once')"
)


def crash_loop(under_test: Bench) -> None:
    """Add a row whose program ends at once, while the robot drives; its CPU is spread over the time it is counted in."""
    robot, results = under_test.robot, under_test.results
    starts = robot.home / "starts.txt"
    mover = under_test.drive()
    calm_ms, calm_cpu = _observe(under_test, lambda: under_test.pass_time(BEFORE_S))
    robot.edit(NEW_ROW, json.dumps({"argv": ["/bin/sh", "-c", CRASHES.format(file=starts)]}))

    def until_given_up() -> None:
        under_test.until(lambda: _phase(under_test)[0] == "failed", GIVES_UP_S, "given up", every_s=0.05)

    began = time.monotonic()
    loop_ms, loop_cpu = _observe(under_test, until_given_up)
    loop_s = (loop_cpu - calm_cpu) * (time.monotonic() - began)
    mover.cease()
    results.sample("P2 CPU", max(0.0, loop_s) / WINDOW_S * 100)
    results.sample("P2 period", loop_ms / calm_ms)
    told = _phase(under_test)[1]
    results.check("P2", [*_backoff(starts), *([] if "given up" in told else [f"given up without a reason: {told!r}"])])
    under_test.until(lambda: under_test.trace.now().zero, 2.0, "rest")


def crash_loops(results: Results, n: int) -> None:
    """P2."""
    for _ in range(n):
        with bench(results) as under_test:
            crash_loop(under_test)


def _observe(under_test: Bench, wait: Callable[[], None]) -> tuple[float, float]:
    """Return the p99 of the motor commands' intervals, and the CPU of executive and ended children, while waiting."""
    pid = under_test.robot.popen.pid
    spent_s, since_ns = _cpu_s(pid), time.monotonic_ns()
    wait()
    took_s = (time.monotonic_ns() - since_ns) * 1e-9
    return percentile(intervals_ms(under_test, since_ns), "p99"), (_cpu_s(pid) - spent_s) / took_s


def _backoff(starts: Path) -> list[str]:
    """Compare the times between starts with what is promised."""
    times = [float(line) for line in starts.read_text().split()]
    waits = [later - earlier for earlier, later in pairwise(times)]
    found = [] if len(waits) == len(DELAYS_S) else [f"started again {len(waits)} times, not {len(DELAYS_S)}"]
    return found + [
        f"{wait_s:.2f} s between two starts, {delay_s:g} s promised"
        for wait_s, delay_s in zip(waits, DELAYS_S, strict=False)
        if not delay_s * (1 - JITTER) <= wait_s <= delay_s * (1 + JITTER) + LATE_S
    ]


def _phase(under_test: Bench) -> tuple[str, str]:
    return next(
        ((unit["phase"], unit["reason"]) for unit in under_test.units() if unit["name"] == "crasher"), ("absent", "")
    )


def _cpu_s(pid: int) -> float:
    times = psutil.Process(pid).cpu_times()
    return float(times.user + times.system + times.children_user + times.children_system)
