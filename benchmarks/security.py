"""Attacks a robot on this machine as somebody would who wants more than they may.

`python -m benchmarks.security --json FILE`; `--only A1,A3` runs a few, `--seconds 600` listens to the network that long.
Exit code 1 if anything passed that must not. A1 needs root, for networks of its own; without it, it is left out.
"""

import argparse
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path

from tests.intrusion import credentials, dependencies, kinds, network, processes, programs, python_lines
from tests.intrusion.promises import PROMISES
from tests.support.figures import Report, Results, machine, table

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


def main() -> int:
    """Attack, print, and say whether anything passed."""
    arguments = _arguments()
    report = measure(arguments.only or list(SCENARIOS), arguments.seconds)
    if arguments.json:
        report.write(arguments.json)
    print(table(report.results))
    return report.tell_broken()


def measure(names: list[str], seconds: float) -> Report:
    """Run one after the other; one that cannot go on counts as a violation."""
    results = Results(PROMISES)
    began, started = time.monotonic(), time.strftime("%Y-%m-%d %H:%M:%S %Z")
    for name in names:
        if name == "A1" and not network.possible():
            print("A1 is left out: it needs root, and the command `ip`", file=sys.stderr)
            continue
        since = time.monotonic()
        for scenario in SCENARIOS[name]:
            try:
                scenario(results, seconds)
            except Exception as err:  # noqa: BLE001 - what went wrong is a finding, and the others are still wanted
                traceback.print_exc()
                results.check(name, [f"could not go on: {err}"])
        print(f"{name}: {time.monotonic() - since:.0f} s", file=sys.stderr, flush=True)
    ordered = [results.by_figure[figure] for figure in PROMISES if figure in results.by_figure]
    return Report(
        machine=machine(),
        load=f"listened for {seconds:g} s",
        started=started,
        took_s=round(time.monotonic() - began, 1),
        results=ordered,
    )


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", type=lambda text: text.split(","), default=[], metavar="A1,A3")
    parser.add_argument("--seconds", type=float, default=10.0, help="to listen to the network (default %(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the result")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
