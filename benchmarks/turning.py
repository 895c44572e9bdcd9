"""Measures how well turns end: by angle and to headings, in simulation, beside the open loop that they replace.

`python -m benchmarks.turning --n 200 --json FILE --table`; nothing sleeps, the same seed gives the same figures. Exit
code 1 if a turn failed, took a revolution too many or longer than it may.
"""

import argparse
import sys
import time
from pathlib import Path

from tests.models.turning import measure
from tests.support.figures import Report, machine, table


def main() -> int:
    """Measure, print, and say whether a hard value was broken."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=200, help="turns and headings together (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the result")
    parser.add_argument("--table", action="store_true", help="print a Markdown table")
    arguments = parser.parse_args()
    began, started = time.monotonic(), time.strftime("%Y-%m-%d %H:%M:%S %Z")
    results = measure(arguments.n, arguments.seed)
    took_s = round(time.monotonic() - began, 1)
    report = Report(machine=machine(), load="I", started=started, took_s=took_s, results=results.ordered())
    if arguments.json:
        report.write(arguments.json)
    if arguments.table or not arguments.json:
        print(table(report.results))
    return report.tell_broken()


if __name__ == "__main__":
    sys.exit(main())
