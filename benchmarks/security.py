"""Attacks a robot on this machine like an intruder.

`python -m benchmarks security --json FILE`; `--only A1,A3` runs a few, `--seconds 600` listens to the network that
long. Exit code 1 if an attack succeeded. A1 needs root, for networks of its own; otherwise it is skipped.
"""

import argparse
import sys
from collections.abc import Callable
from functools import partial

from benchmarks import Measured, listed, one_by_one
from tests.intrusion import credentials, dependencies, kinds, network, processes, programs, python_lines
from tests.intrusion.promises import PROMISES
from tests.support.figures import Results

SMOKE = "--only A14"

Scenario = Callable[[Results, float], None]
SCENARIOS: dict[str, tuple[Scenario, ...]] = {
    "A1": (network.silence,),
    "A3": (lambda results, _seconds: credentials.credentials(results),),
    "A10": (lambda results, _seconds: python_lines.python_lines(results),),
    "A11": (lambda results, _seconds: kinds.kinds(results), lambda results, _seconds: kinds.places(results)),
    "A12": (lambda results, _seconds: programs.programs(results),),
    "A14": (lambda results, _seconds: dependencies.dependencies(results),),
    "A15": (lambda results, _seconds: processes.processes(results),),
}


def options(parser: argparse.ArgumentParser) -> None:
    """Add the attacks, and the duration."""
    parser.add_argument("--only", type=listed, default=list(SCENARIOS), metavar="A1,A3")
    parser.add_argument("--seconds", type=float, default=10.0, help="to listen to the network (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Attack, one way after the other."""
    results, names = Results(PROMISES), given.only
    if "A1" in names and not network.possible():
        print("A1 is left out: it needs root, and the command `ip`", file=sys.stderr)
        names = [name for name in names if name != "A1"]
    one_by_one(
        results,
        ((name, name, partial(attack, results, given.seconds)) for name in names for attack in SCENARIOS[name]),
    )
    return Measured(results=results.ordered(), load=f"listened for {given.seconds:g} s")
