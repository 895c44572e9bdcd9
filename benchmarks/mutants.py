"""Measures the share of small faults that the tests find, in the code that stops, limits, lends, decodes and stores.

`python -m benchmarks mutants --each 16`. So many faults are drawn for each part: a changed operator or bound, a missing
check or step. Each is put into a copy of this tree by itself. The tests that run its line then run on it, the quickest
first, until one fails. The tests of each line are measured before, once for each part, without those that need a whole
robot. A fault that they do not find is tried on the part's tests with real processes (`--robots`). Faults without any
visible effect are in `instruments/equal_mutants.toml`, each with its reason. A fault that was only found by time (a
test or the whole run took too long) is reported, since a busy machine does the same. `--again FILE` tries those and the
unfound ones once more, `--by TEST,…` quickly.
"""

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator
from collections.abc import Set as AbstractSet
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from fnmatch import fnmatch
from pathlib import Path

import coverage
import msgspec
from msgspec import Struct

from benchmarks import FOLDER, Measured, listed
from benchmarks.instruments.mutation import Mutant, mutants
from tests.support import programs
from tests.support.figures import Promise, Result

SMOKE = "--each 1 --parts leases"
ROOT = FOLDER.parent
EQUAL = FOLDER / "instruments" / "equal_mutants.toml"
LEFT_OUT = shutil.ignore_patterns(".git", ".venv", "node_modules", "__pycache__", ".*_cache", ".hypothesis", "build")
LONGEST_S = 120.0
"""A fault whose tests have not ended by then has stopped something: it is found."""
QUICK_S = 60.0
"""The tests of one fault are the quickest that run its line, up to so many seconds."""


class Part(Struct, frozen=True):
    """A part of the code, and its tests: in one process, and with real ones."""

    code: tuple[str, ...]
    tests: tuple[str, ...]
    robots: tuple[str, ...] = ("tests/safety",)
    stops: bool = False


PARTS = {
    "leases": Part(
        ("lbr/leases/*.py", "lbr/operations/lender.py"),
        (
            "tests/leases",
            "tests/operations/test_lender.py",
            "tests/operations/drive",
            "tests/operations/joints/test_joints_capability.py",
            "tests/models",
            "tests/bus/test_wire.py",
        ),
        stops=True,
    ),
    "drive": Part(("lbr/operations/drive/*.py",), ("tests/operations/drive", "tests/models"), stops=True),
    "joints": Part(("lbr/operations/joints/*.py",), ("tests/operations/joints", "tests/models"), stops=True),
    "wheels": Part(
        ("lbr/drivers/wheels/*.py", "lbr/drivers/setpoint_gate.py"),
        ("tests/drivers/test_wheels*.py", "tests/drivers/test_setpoint_gate.py", "tests/testing", "tests/drivers/test_roboteq*.py"),
        stops=True,
    ),
    "servos": Part(
        ("lbr/drivers/servos/*.py",),
        ("tests/drivers/test_servos*.py", "tests/drivers/test_dynamixel*.py", "tests/testing"),
        stops=True,
    ),
    "roboteq": Part(("lbr/drivers/roboteq/*.py",), ("tests/drivers/test_roboteq*.py",)),
    "guard": Part(
        ("lbr/drivers/guard.py", "lbr/drivers/*/guard*.py", "lbr/drivers/servos/gate.py", "lbr/drivers/wheels/arming.py"),
        ("tests/drivers/test_*guard*.py", "tests/drivers/test_wheels*.py", "tests/drivers/test_servos*.py", "tests/testing"),
        stops=True,
    ),
    "bus": Part(
        ("lbr/bus/*.py",), ("tests/bus", "tests/capability", "tests/messages", "tests/simulation/trials/test_stage.py")
    ),
    "database": Part(("lbr/database/*.py",), ("tests/database",), ("tests/commands", "tests/safety/test_data.py")),
    "executive": Part(
        ("lbr/executive/*.py", "lbr/executive/planning/*.py", "lbr/executive/processes/*.py", "lbr/executive/service/*.py"),
        ("tests/executive",),
        ("tests/executive", "tests/safety"),
    ),
}  # fmt: skip


MISSED = "small faults that no test of README's command finds"
PROMISES = {
    "M1": Promise(what=f"{MISSED}, of those in the code that stops, limits, lends, decodes and stores", unit="%"),
    "M1 stops": Promise(what=f"{MISSED}, of those in what stops motion", unit="%", target=10.0),
    **{f"M1 {name}": Promise(what=f"{MISSED}, of those in {name}", unit="%") for name in PARTS},
}
EQUALS = "(equal)"
NOT_ENDED = "(did not end)"
SLOW = (NOT_ENDED, "(ended", "Timeout", "ERROR: not found")
"""Results that a busy machine, or a renamed test, also gives."""


class Outcome(Struct):
    """The result of one fault."""

    part: str
    fault: str
    line: int
    operator: str
    found_by: str
    """The test that failed, and why; empty without one."""
    tests: int

    @property
    def found(self) -> bool:
        """Return whether a test failed."""
        return self.found_by not in {"", EQUALS}

    @property
    def doubtful(self) -> bool:
        """Return whether only time has found the fault."""
        return any(word in self.found_by for word in SLOW)


class Trial:
    """Copies of this tree, one for each worker, in which tests run on a fault."""

    def __init__(self, folder: Path, workers: int) -> None:
        self.trees = [folder / f"tree{number}" for number in range(workers)]
        for tree in self.trees:
            shutil.copytree(ROOT, tree, ignore=LEFT_OUT)
        self._free = list(self.trees)

    def measure(self, part: Part) -> tuple[coverage.CoverageData, dict[str, float]]:
        """Run a part's tests in one process; return the tests by line, and their durations."""
        tree = self.trees[0]
        times, data = tree / "times.json", tree / ".coverage"
        data.unlink(missing_ok=True)
        sources = sorted({str(Path(pattern).parent) for pattern in part.code if (tree / pattern).parent.is_dir()})
        words = ["--cov-report=", "--cov-context=test", *(f"--cov={source}" for source in sources)]
        words += [
            "-p",
            "benchmarks.instruments.test_times",
            "-m",
            "not slow_start and not nightly",
            *_there(tree, part.tests),
        ]
        self._pytest(tree, words, 3000.0, LBR_TEST_TIMES=str(times))
        found = coverage.CoverageData(str(data))
        found.read()
        return found, json.loads(times.read_text())

    def run(self, mutant: Mutant, tests: list[str]) -> str:
        """Run tests on a fault; return the first that fails, empty without one."""
        tree = self._free.pop()
        target = tree / mutant.path
        source = target.read_text()
        names = tree / "names.txt"
        names.write_text("".join(f"{test}\n" for test in tests))
        try:
            target.write_text(mutant.put_into(source))
            return self._pytest(tree, ["-x", f"@{names}"], LONGEST_S + 3 * QUICK_S)
        finally:
            target.write_text(source)
            self._free.append(tree)

    @staticmethod
    def _pytest(tree: Path, words: list[str], limit_s: float, **environment: str) -> str:
        argv = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", "--tb=line", "-rfE", *words]
        surroundings = os.environ | {"PYTHONPATH": str(tree), "COLUMNS": "300"} | environment
        with tempfile.TemporaryFile("w+") as printed:
            program = programs.start(
                argv, cwd=tree, env=surroundings, stdout=printed, stderr=printed, start_new_session=True
            )
            try:
                code = program.wait(limit_s)
            except subprocess.TimeoutExpired:
                with suppress(ProcessLookupError):
                    os.killpg(program.pid, signal.SIGKILL)
                program.wait()
                return NOT_ENDED
            if code == 0:
                return ""
            printed.seek(0)
            lines = [line for line in printed.read().splitlines() if line.startswith(("FAILED", "ERROR"))]
            return lines[0] if lines else f"(ended with {code})"


def options(parser: argparse.ArgumentParser) -> None:
    """Add the number of faults, and the parts."""
    parser.add_argument("--each", type=int, default=16, help="faults of each part (16)")
    parser.add_argument("--parts", type=listed, default=list(PARTS), help=f"which, of {','.join(PARTS)}")
    parser.add_argument("--seed", type=int, default=1, help="which faults are drawn (1)")
    parser.add_argument("--workers", type=int, default=1, help="how many are tried at a time (1)")
    parser.add_argument(
        "--outcomes", type=Path, metavar="FILE", help="keep each fault, and what found it, in this file"
    )
    parser.add_argument(
        "--again", type=Path, nargs="+", default=[], metavar="FILE", help="try what such a file says is open, only"
    )
    parser.add_argument("--by", type=listed, default=[], help="tests to try them by, instead of those that run a line")
    parser.add_argument("--robots", action="store_true", help="try what is not found on tests with real processes, too")


def measure(given: argparse.Namespace) -> Measured:
    """Draw faults, try each, and count the found ones by part."""
    equal = tomllib.loads(EQUAL.read_text())
    known = [one for path in given.again for one in msgspec.json.decode(path.read_bytes(), type=list[Outcome])]
    outcomes: list[Outcome] = []
    with tempfile.TemporaryDirectory(prefix="lbr-mutants-") as folder:
        trial = Trial(Path(folder), given.workers)
        for name in given.parts:
            before = [one for one in known if one.part == name]
            outcomes += _again(trial, name, given, before, equal) if known else _drawn(trial, name, given, equal)
            if given.outcomes:
                given.outcomes.write_bytes(msgspec.json.format(msgspec.json.encode(outcomes)))
    told = [f"found by time alone: {one.fault} (line {one.line}): {one.found_by}" for one in outcomes if one.doubtful]
    told += [f"not found: {one.fault} (line {one.line})" for one in outcomes if not one.found_by]
    load = f"{len(outcomes)} faults, seed {given.seed}"
    return Measured(results=_results(outcomes), load=load, text="\n".join([*_table(outcomes), "", *told]))


def faults_of(name: str) -> list[Mutant]:
    """Return every possible fault of a part."""
    paths = sorted({str(path.relative_to(ROOT)) for pattern in PARTS[name].code for path in ROOT.glob(pattern)})
    return [mutant for path in paths for mutant in mutants(ROOT, path)]


def _drawn(trial: Trial, name: str, given: argparse.Namespace, equal: dict[str, str]) -> list[Outcome]:
    every = faults_of(name)
    drawn = random.Random(f"{given.seed} {name}").sample(every, min(given.each, len(every)))
    return _tried(trial, name, given, drawn, equal)


def _again(
    trial: Trial, name: str, given: argparse.Namespace, before: list[Outcome], equal: dict[str, str]
) -> list[Outcome]:
    """Try the faults that nothing or only time had found; the other results stay."""
    known = {(mutant.name, mutant.line): mutant for mutant in faults_of(name)}
    open_ = [known[one.fault, one.line] for one in before if one.doubtful or not one.found_by]
    new = {(one.fault, one.line): one for one in (_tried(trial, name, given, open_, equal) if open_ else [])}
    return [new.get((one.fault, one.line), one) for one in before]


def _tried(
    trial: Trial, name: str, given: argparse.Namespace, faults: list[Mutant], equal: dict[str, str]
) -> list[Outcome]:
    part, began = PARTS[name], time.monotonic()
    lines, took_s = (None, {}) if given.by else trial.measure(part)
    print(f"{name}: {len(took_s)} tests, {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)

    def tried(mutant: Mutant) -> Outcome:
        if mutant.name in equal:
            return Outcome(name, mutant.name, mutant.line, mutant.operator, EQUALS, 0)
        tests = given.by if lines is None else _tests(trial.trees[0], mutant, lines, took_s)
        found_by = trial.run(mutant, tests) if tests else ""
        if not found_by and given.robots:
            found_by = trial.run(mutant, _there(trial.trees[0], part.robots))
        print(f"  {found_by or 'NOT FOUND'}: {mutant.name} ({mutant.line})", file=sys.stderr, flush=True)
        return Outcome(name, mutant.name, mutant.line, mutant.operator, found_by, len(tests))

    with ThreadPoolExecutor(given.workers) as pool:
        return list(pool.map(tried, faults))


def _tests(tree: Path, mutant: Mutant, lines: coverage.CoverageData, took_s: dict[str, float]) -> list[str]:
    """Return the tests that run a fault's lines, the quickest first; then the others, whose programs may run them."""
    by_line = lines.contexts_by_lineno(str(tree / mutant.path))
    contexts = {context for line in range(mutant.line, mutant.end_line + 1) for context in by_line.get(line, [])}
    if contexts == {""}:  # it runs when the module is imported: every user of the module may find it
        contexts = {context for every in by_line.values() for context in every}
    running = {context.split("|")[0] for context in contexts} & took_s.keys()
    return [*_quickest(running, took_s), *_quickest(took_s.keys() - running, took_s)]


def _quickest(tests: AbstractSet[str], took_s: dict[str, float]) -> list[str]:
    chosen, total_s = [], 0.0
    for test in sorted(tests, key=lambda test: took_s[test]):
        total_s += took_s[test]
        if total_s > QUICK_S:
            break
        chosen.append(test)
    return chosen


def _there(tree: Path, tests: tuple[str, ...]) -> list[str]:
    """Return the existing ones of these tests."""
    modules = [str(path.relative_to(tree)) for path in sorted((tree / "tests").rglob("*"))]
    return sorted({path for pattern in tests for path in modules if fnmatch(path, pattern)})


def _groups(outcomes: list[Outcome]) -> Iterator[tuple[str, list[Outcome]]]:
    """Yield each part with its outcomes, those that stop motion, and all."""
    for name in dict.fromkeys(one.part for one in outcomes):
        yield name, [one for one in outcomes if one.part == name]
    yield "stops", [one for one in outcomes if PARTS[one.part].stops]
    yield "", outcomes


def _results(outcomes: list[Outcome]) -> list[Result]:
    results = []
    for name, group in _groups(outcomes):
        tried = [one for one in group if one.found_by != EQUALS]
        if tried:
            figure, share = f"M1 {name}".strip(), sum(not one.found for one in tried) / len(tried)
            percent = [round(100 * share, 1)]
            results.append(Result(figure=figure, promise=PROMISES[figure], samples=percent, checks=len(tried)))
    return results


def _table(outcomes: list[Outcome]) -> list[str]:
    rows = []
    for name, group in _groups(outcomes):
        found, equal = sum(one.found for one in group), sum(one.found_by == EQUALS for one in group)
        missed, tried = len(group) - found - equal, len(group) - equal
        share = f"{found / tried:.0%}" if tried else ""
        rows.append(f"| {name or 'all'} | {len(group)} | {found} | {equal} | {missed} | {share} |")
    return ["| part | drawn | found | equal | missed | share found |", "|---|--:|--:|--:|--:|--:|", *rows]
