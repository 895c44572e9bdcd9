"""P9, P10 and B5: more rows than fit, edits without end, and a start on a machine that has too much to do."""

import time
from functools import partial

import psutil

from tests.scenarios.load import busy_loops
from tests.support.bench import let_go, temporary_home
from tests.support.figures import Results
from tests.support.robot import Robot, start
from tests.support.waiting import until

AT_ONCE, FITTING = 300, 40
ADD_MANY = (
    "WITH RECURSIVE n(i) AS (VALUES(0) UNION ALL SELECT i + 1 FROM n WHERE i < {last})"
    " INSERT INTO capability (robot, name, kind) SELECT 'lbr', 'row' || i, 'telemetry' FROM n"
)
TAKE_BACK = "DELETE FROM capability WHERE name LIKE 'row%'"
STARTS_WITHIN_S = 300.0


def rows_at_once(results: Results, n: int) -> None:
    """P9: all of them at once, too many and many; a stop, the emergency stop and the status are asked for meanwhile."""
    for _ in range(n):
        with temporary_home() as home:
            robot = start(home)
            for count in (AT_ONCE, FITTING):
                robot.edit(ADD_MANY.format(last=count - 1))
                until(partial(_settled, robot, results, count))
                robot.edit(TAKE_BACK)
                until(partial(_gone, robot))
            _hear(robot, results, "estop")
            let_go(robot)


def edits_without_end(results: Results, n: int) -> None:
    """P10: a capability is added and removed `n` times; what that cost the executive is free again."""
    with temporary_home() as home:
        robot = start(home)
        executive = psutil.Process(robot.ready["pid"])
        _add_and_remove(robot)  # what is made once, at the first edit, is no growth
        before = _cost(executive)
        for _ in range(n):
            _add_and_remove(robot)
        time.sleep(11.0)  # threads of the bus library that have nothing to do end after ten seconds
        grown = [after - was for after, was in zip(_cost(executive), before, strict=True)]
        for figure, more in zip(("P10", "P10 threads", "P10 memory"), grown, strict=True):
            results.sample(figure, more)
        begun = time.monotonic()
        let_go(robot)
        results.sample("P10 end", (time.monotonic() - begun) * 1000)


def busy_start(results: Results, n: int) -> None:
    """B5: start under busy loops, four and, if there is time for more than one, thirty; nothing is killed for being held up."""
    for _ in range(n):
        for load, loops in (("H", 4), ("30", 30))[: 1 if n == 1 else 2]:
            with temporary_home(whole=True) as home, busy_loops(loops):
                begun = time.monotonic()
                robot = start(home, limit_s=STARTS_WITHIN_S)
                results.sample(f"B5 {load}", (time.monotonic() - begun) * 1000)
                ends = [f"{one['name']} ended" for one in robot.status()["capabilities"] if one["restarts"]]
                results.check("B5", [*ends, *(["not ready"] if not robot.ready["ready"] else [])])
                let_go(robot)


def _settled(robot: Robot, results: Results, count: int) -> bool:
    for line in ("s", "/report/health"):
        _hear(robot, results, line)
    status = robot.status()
    ours = [one["phase"] for one in status["capabilities"] if one["name"].startswith("row")]
    return bool(status["problems"]) if count > FITTING else ours.count("ready") == count


def _gone(robot: Robot) -> bool:
    status = robot.status()
    return not status["problems"] and not any(one["name"].startswith("row") for one in status["capabilities"])


def _hear(robot: Robot, results: Results, line: str) -> None:
    begun = time.monotonic()
    heard = robot.line(line)
    results.sample("P9", (time.monotonic() - begun) * 1000)
    results.check("P9 heard", [] if heard["code"] == 0 else [f"'{line}': {heard['text']}"])


def _add_and_remove(robot: Robot) -> None:
    robot.edit(ADD_MANY.format(last=0))
    until(lambda: robot.capability("row0")["phase"] == "ready")
    robot.edit(TAKE_BACK)
    until(lambda: robot.capability("row0")["phase"] == "absent")


def _cost(executive: psutil.Process) -> tuple[float, float, float]:
    """Return descriptors, threads and memory in MiB."""
    return executive.num_fds(), executive.num_threads(), executive.memory_info().rss / 2**20
