"""Measures how soon the motors stand after every kind of fault, and how the robot recovers.

`python -m benchmarks.safety --n 30 --json benchmarks/results.json --table`; `--only S1,S3` runs a few scenarios,
`--write-docs` puts the table of a JSON result into docs/safety.md. Exit code 1 if a hard value is broken.
"""

import argparse
import os
import platform
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path

import msgspec

from benchmarks.figures import Report, Result, Results, table
from benchmarks.promises import PROMISES
from benchmarks.scenarios import (
    bounds,
    clients,
    crashes,
    devices,
    edits,
    estop,
    freezes,
    kills,
    load,
    shutdown,
    starts,
    writers,
)

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs" / "safety.md"
RESULTS = ROOT / "benchmarks" / "results.json"
BEGIN, END = "<!-- figures:begin -->", "<!-- figures:end -->"
EDIT_SECONDS = 60

Scenario = Callable[[Results, int], None]
SCENARIOS: dict[str, tuple[Scenario, float]] = {
    "S1": (kills.kill_motor_driver, 1.0),
    "S2": (freezes.repeated(freezes.motor_driver_frozen), 1.0),
    "S3": (kills.kill_drive, 1.0),
    "S4": (freezes.repeated(freezes.drive_frozen), 1.0),
    "S5": (freezes.repeated(freezes.links_broken), 1.0),
    "S6": (kills.kill_executive, 0.5),
    "S7": (freezes.repeated(freezes.executive_frozen, freezes.client_frozen), 0.5),
    "S11": (freezes.repeated(freezes.everything_frozen), 0.5),
    "S12": (freezes.repeated(freezes.driver_and_guard_killed), 0.5),
    "S8": (clients.clients_gone, 0.3),
    "S13": (crashes.crashes, 0.1),
    "S15": (devices.range_board, 0.2),
    "S16": (devices.motor_line, 0.3),
    "S18": (bounds.bounds, 1.0),
    "E1": (estop.estop, 1.5),
    "B1": (load.steady, 0.1),
    "F7": (writers.one_writer, 0.1),
    "P1": (kills.kill_others, 0.2),
    "P4": (shutdown.shutdowns, 0.15),
    "P5": (crashes.hangs, 0.1),
    "P6": (starts.starts, 0.3),
    "P7": (starts.hardware, 0.1),
    "P8": (edits.edits, EDIT_SECONDS / 30),
}
"""Each with its share of `--n`: some take ten times as long as others, or try ten ways each time. P8 counts seconds."""


def main() -> int:
    """Measure, print, and say whether a hard value was broken."""
    arguments = _arguments()
    if arguments.write_docs:
        return _write_docs(arguments.json or RESULTS)
    report = measure(arguments.only or list(SCENARIOS), arguments.n, arguments.load)
    if arguments.json:
        arguments.json.write_bytes(msgspec.json.encode(report).replace(b'{"figure"', b'\n{"figure"') + b"\n")
    if arguments.table or not arguments.json:
        print(table(report.results))
    return _tell(report.results)


def measure(names: list[str], n: int, load: str) -> Report:
    """Run scenarios one after the other; one that cannot go on counts as a violation, and the next begins."""
    results = Results(PROMISES)
    began, started = time.monotonic(), time.strftime("%Y-%m-%d %H:%M:%S %Z")
    for name in names:
        scenario, share = SCENARIOS[name]
        since = time.monotonic()
        try:
            scenario(results, max(1, round(n * share)))
        except Exception as err:  # noqa: BLE001 - what went wrong is a finding, and the others are still wanted
            traceback.print_exc()
            figure = next(figure for figure in PROMISES if figure.split()[0] == name)
            results.check(figure, [f"the scenario could not go on: {err}"])
        print(f"{name}: {time.monotonic() - since:.0f} s", file=sys.stderr, flush=True)
    for text in results.disturbed:
        print(f"not counted: {text}", file=sys.stderr)
    ordered = [results.by_figure[figure] for figure in PROMISES if figure in results.by_figure]
    machine = (
        f"{os.cpu_count()} cores, {platform.machine()}, Linux {platform.release()}, Python {sys.version.split()[0]}"
    )
    return Report(
        machine=machine, load=load, started=started, took_s=round(time.monotonic() - began, 1), results=ordered
    )


def _tell(results: list[Result]) -> int:
    broken = [result for result in results if result.verdict == "broken"]
    for result in broken:
        for text in result.violations[:5] or ["above its hard limit"]:
            print(f"BROKEN {result.figure}: {text}", file=sys.stderr)
    return 1 if broken else 0


def _write_docs(path: Path) -> int:
    report = msgspec.json.decode(path.read_bytes(), type=Report)
    if not DOCS.exists() or BEGIN not in (text := DOCS.read_text()):
        print(f"{DOCS} has no {BEGIN}; nothing written", file=sys.stderr)
        return 1
    head, _, rest = text.partition(BEGIN)
    tail = rest.partition(END)[2]
    about = f"Measured {report.started} on {report.machine}; {report.load}; {report.took_s:.0f} s in all."
    DOCS.write_text(f"{head}{BEGIN}\n{about}\n\n{table(report.results)}\n{END}{tail}")
    return 0


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=10, help="how often each scenario, more or less (default %(default)s)")
    parser.add_argument("--only", type=_names, metavar="S1,S3", help=f"of {', '.join(SCENARIOS)}")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the result, or read it with --write-docs")
    parser.add_argument("--table", action="store_true", help="print a Markdown table")
    parser.add_argument("--load", default="nothing else running", help="what else the machine does, for the record")
    parser.add_argument("--write-docs", action="store_true", help="fill docs/safety.md from a JSON result")
    return parser.parse_args()


def _names(text: str) -> list[str]:
    names = text.split(",")
    if unknown := [name for name in names if name not in SCENARIOS]:
        raise argparse.ArgumentTypeError(f"no scenario {', '.join(unknown)}; there are {', '.join(SCENARIOS)}")
    return names


if __name__ == "__main__":
    sys.exit(main())
