"""Measures how soon the motors stand after every kind of fault, and how the robot recovers.

`python -m benchmarks safety --n 30` is about a tenth of the full amount; `--only S1,S3` runs a few scenarios. `--gate`
tries everything in under five minutes, several at a time, for hard values only. `--full` is the whole amount in ten
rounds, `--minutes 120` as many of them as fit. `--merge FILE` adds a benchmark's `--json` file to
benchmarks/results.json, and `--write-docs` makes the table in benchmarks/figures.md of that. Exit code 1 if a hard
value is broken.

Most scenarios run the base of lbr alone: motors, ranges, drive and world. With `--whole` they run lbr-sim as it ships.
Measurements that were repeated, because the machine was too busy with others, are reported and kept with the result.
`--whole --tries 100 --only S1,S2,S3,S4,S5,S6,S7,S8` takes three quarters of an hour.
"""

import argparse
import ctypes
import multiprocessing
import signal
import sys
import time
import traceback
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import msgspec
from msgspec import Struct

from benchmarks import Measured
from lbr.capability.die_with_parent import PR_SET_PDEATHSIG
from tests.scenarios.promises import PROMISES
from tests.scenarios.schedule import FIGURE_OF, SCENARIOS
from tests.support.figures import Report, Result, Results
from tests.support.ledger import Ledger
from tests.support.machine import Moment, share

SMOKE = "--tries 1 --only S1"

ROUNDS = 10
GATE_JOBS = 4


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount, the scenarios, and the robot; or the files to merge."""
    amount = parser.add_mutually_exclusive_group()
    amount.add_argument("--n", type=int, default=10, help="how much; 300 is the full amount (default %(default)s)")
    amount.add_argument("--tries", type=int, default=0, help="this many tries of each scenario, as in --only S1,S8")
    amount.add_argument("--gate", action="store_true", help="everything in under five minutes")
    amount.add_argument("--full", action="store_true", help="the full amount, in ten rounds")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="begin no round of --full that ends later")
    parser.add_argument("--jobs", type=int, default=0, help=f"scenarios at a time ({GATE_JOBS} for --gate, else 1)")
    parser.add_argument("--only", type=_names, metavar="S1,S3", help=f"of {', '.join(SCENARIOS)}")
    parser.add_argument("--whole", action="store_true", help="on lbr-sim as it ships, not on its base")
    parser.add_argument("--load", default="nothing else running", help="what else the machine does, for the record")
    parser.add_argument("--merge", type=Path, nargs="+", default=[], metavar="FILE", help="keep these results")
    parser.add_argument("--write-docs", action="store_true", help="fill benchmarks/figures.md from what is kept")


def measure(given: argparse.Namespace) -> Measured | None:
    """Run scenarios, or merge measurements."""
    if given.merge or given.write_docs:
        keep(given.merge, write_docs=given.write_docs)
        return None
    return together(rounds(given), given.load, jobs=given.jobs or (GATE_JOBS if given.gate else 1), whole=given.whole)


class Run(NamedTuple):
    """One scenario, with a number of repetitions."""

    name: str
    n: int
    whole: bool = False


def together(rounds: Iterable[list[Run]], load: str, *, jobs: int = 1, whole: bool = False) -> Measured:
    """Run all rounds; with several jobs, most scenarios run beside others."""
    results = Results(PROMISES, whole=whole)
    began = Moment.now()
    for plan in rounds:
        runs = [run._replace(whole=whole) for run in plan]
        shared = [run for run in runs if not SCENARIOS[run.name].alone] if jobs > 1 else []
        _beside_others(results, shared, jobs)
        for run in runs:
            if run not in shared:
                _by_itself(results, run, once_more=jobs > 1)
    return Measured(
        load=f"{load}; no program waited for {share(began, Moment.now()):.0%} of the time",
        results=results.ordered(),
        repeated=results.repeated,
        disturbed=results.disturbed,
    )


class Outcome(Struct, frozen=True):
    """The measurements of a run, and their state on a busy machine."""

    results: list[Result]
    disturbed: list[str]
    repeated: list[str]
    gave_up: bool

    @property
    def may_be_the_machine(self) -> bool:
        """Return whether it only could not go on, or took too long."""
        broken = [result for result in self.results if result.verdict == "broken"]
        return self.gave_up or (bool(broken) and not any(result.violations for result in broken))

    @property
    def why(self) -> str:
        """Return what was wrong."""
        broken = [result for result in self.results if result.verdict == "broken"]
        texts = [
            f"{result.figure} {max(result.samples):.0f} {result.promise.unit}, at most {result.promise.hard:g}"
            if result.samples and not result.violations
            else f"{result.figure}: {', '.join(result.violations[:1]) or 'nothing measured'}"
            for result in broken
        ]
        return "; ".join(texts)


def run_alone(run: Run) -> bytes:
    """Run a scenario; one that cannot go on counts as a violation. Return an encoded Outcome."""
    results = Results(PROMISES, whole=run.whole)
    since = time.monotonic()
    gave_up = False
    try:
        SCENARIOS[run.name].run(results, run.n)
    except Exception as err:  # noqa: BLE001 - what went wrong is a finding, and the others are still wanted
        traceback.print_exc()
        gave_up = True
        figures = [figure for figure in PROMISES if figure.split()[0] == run.name]
        figure = FIGURE_OF.get(run.name) or (run.name if run.name in figures else figures[0])
        results.check(figure, [f"the scenario could not go on: {err}"])
    print(f"{run.name}: {run.n}, {time.monotonic() - since:.0f} s", file=sys.stderr, flush=True)
    return msgspec.json.encode(Outcome(results.ordered(), results.disturbed, results.repeated, gave_up))


def _beside_others(results: Results, runs: list[Run], jobs: int) -> None:
    """Run several at a time; repeat by itself a failure that may be due to the machine, and report that.

    The repetition counts. If it may be due to the machine as well, which has other users, the next one counts.
    """
    if not runs:
        return
    again: list[Run] = []
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=context, initializer=_end_with_parent) as pool:
        for run, encoded in zip(runs, pool.map(run_alone, runs), strict=True):
            outcome = msgspec.json.decode(encoded, type=Outcome)
            if outcome.may_be_the_machine:
                again.append(run)
                results.repeated.append(f"{run.name}, by itself: beside {jobs - 1} others {outcome.why}")
            else:
                _take(results, encoded)
    for run in again:
        _by_itself(results, run, once_more=True)


def _by_itself(results: Results, run: Run, *, once_more: bool) -> None:
    """Run a scenario alone; with `once_more`, repeat a failure that may be due to the machine, and report that."""
    encoded = run_alone(run)
    outcome = msgspec.json.decode(encoded, type=Outcome)
    if once_more and outcome.may_be_the_machine:
        results.repeated.append(f"{run.name}, once more by itself: {outcome.why}")
        encoded = run_alone(run)
    _take(results, encoded)


def _take(results: Results, encoded: bytes) -> None:
    outcome = msgspec.json.decode(encoded, type=Outcome)
    results.add(outcome.results, outcome.disturbed, outcome.repeated)


def _end_with_parent() -> None:
    """Have the kernel kill a process of the pool, with its children, when this benchmark is killed."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def rounds(arguments: argparse.Namespace) -> Iterator[list[Run]]:
    """Yield the runs: one round, or the full amount in tenths until the time is over."""
    names = arguments.only or list(SCENARIOS)
    if arguments.gate:
        yield [Run(name, SCENARIOS[name].gate) for name in names]
        return
    if arguments.tries:
        yield [Run(name, SCENARIOS[name].for_tries(arguments.tries)) for name in names]
        return
    if not arguments.full:
        yield [Run(name, SCENARIOS[name].amount(arguments.n)) for name in names]
        return
    end, longest_s = time.monotonic() + arguments.minutes * 60, 0.0
    for turn in range(ROUNDS):
        began = time.monotonic()
        if began + longest_s > end:
            print(f"{turn} of {ROUNDS} rounds in {arguments.minutes:g} minutes", file=sys.stderr)
            return
        yield [Run(name, _tenth(SCENARIOS[name].full, turn)) for name in names if _tenth(SCENARIOS[name].full, turn)]
        longest_s = max(longest_s, time.monotonic() - began)


def _tenth(full: int, turn: int) -> int:
    return full * (turn + 1) // ROUNDS - full * turn // ROUNDS


def keep(paths: list[Path], *, write_docs: bool) -> None:
    """Merge reports of any benchmark into the kept ones, and optionally make their table."""
    ledger = Ledger.read()
    for path in paths:
        ledger.merge(msgspec.json.decode(path.read_bytes(), type=Report))
    if paths:
        ledger.write()
    if write_docs:
        ledger.write_docs()


def _names(text: str) -> list[str]:
    names = text.split(",")
    if unknown := [name for name in names if name not in SCENARIOS]:
        raise argparse.ArgumentTypeError(f"no scenario {', '.join(unknown)}; there are {', '.join(SCENARIOS)}")
    return names
