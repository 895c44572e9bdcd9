"""Measures the cost of a state table: one evaluation of a table of 1,000 states against 500 values, and reading it.

`python -m benchmarks behaviours --n 2000 --json FILE`; nothing sleeps, no robot runs. The process evaluates twenty
times a second: `step` is one evaluation, `why` also finds the unmet conditions of each row, and `all` evaluates the
rows of all states.
"""

import argparse
import time
from collections.abc import Callable

from benchmarks import Measured
from lbr.apps.behaviours.kernel import Run
from lbr.apps.behaviours.keys import Key
from lbr.apps.behaviours.table import Table, compile_table
from lbr.messages.behaviour import BehaviourRow, BehaviourTable
from tests.support.figures import Promise, Results

SMOKE = "--n 5 --states 20"
VALUES = 500
ROWS = 3
PROMISES = {
    "B1": Promise(what="one step of a run in a table of 1,000 states", target=1.0, statistic="p99"),
    "B2": Promise(what="why each row of the state is not taken", target=1.0, statistic="p99"),
    "B3": Promise(what="every row of all states, not only of the one that it is in"),
    "B4": Promise(what="reading and checking such a table", target=1000.0, statistic="p99"),
}


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount."""
    parser.add_argument("--n", type=int, default=2000, help="evaluations (default %(default)s)")
    parser.add_argument("--states", type=int, default=1000, help="of the table (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Evaluate a large table repeatedly."""
    results = Results(PROMISES)
    table, rows = _table(given.states)
    compiled: list[Table] = []

    def read() -> None:
        found = compile_table(table, rows).table
        assert found is not None
        compiled[:] = [found]

    for _ in range(max(1, given.n // 1000)):
        results.sample("B4", _taken_ms(read))
    values = {f"joints.joints.j{number}.position_rad": 0.0 for number in range(VALUES)}

    def look(key: Key, _newest_s: float) -> float | None:
        return values.get(key.column)

    run, now = Run(compiled[0], {}, 0.0, lambda _count: 0), 0.0
    conditions = [line.conditions for state in compiled[0].states.values() for line in state.lines]

    def every() -> None:
        for line in conditions:
            all(one.cell.fits.off(look(one.key, one.newest_s)) == 0.0 for one in line)

    for number in range(given.n):
        now = number * 0.05
        results.sample("B1", _taken_ms(lambda: run.step(now, look)))  # noqa: B023 - called at once
        results.sample("B2", _taken_ms(lambda: run.why(now, look)))  # noqa: B023 - called at once
        if number % 20 == 0:
            results.sample("B3", _taken_ms(every))
    return Measured(results=results.ordered())


def _table(states: int) -> tuple[BehaviourTable, list[BehaviourRow]]:
    """Return a table whose rows never hold, so that each is evaluated."""
    rows: list[BehaviourRow] = []
    for number in range(states):
        for row in range(ROWS):
            column = f"joints.joints.j{(number * ROWS + row) % VALUES}.position_rad"
            last = number == states - 1
            rows.append(
                BehaviourRow(
                    behaviour="large",
                    step=len(rows) + 1,
                    type="start" if number == 0 else "",
                    state=f"s{number}",
                    conditions={column: f"{row + 1}:{row + 1.5}", "Time": ">= 0"},
                    next_state="end" if last else f"s{number + 1}",
                )
            )
    rows.append(BehaviourRow(behaviour="large", step=len(rows) + 1, type="end", state="end"))
    return BehaviourTable(name="large", max_s=0.0), rows


def _taken_ms(do: Callable[[], object]) -> float:
    began = time.thread_time()  # the processor time: other processes may run meanwhile
    do()
    return (time.thread_time() - began) * 1000.0
