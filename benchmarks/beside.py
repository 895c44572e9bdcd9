"""Runs the same benchmark of another checkout in turns with this one, so that the machine's state affects both equally.

`python -m benchmarks beside --checkout ../before --rounds 5 --run 'latency --n 200'`. The other one has an environment
of its own in `.venv`. Each figure in both tables is printed as the median of its rounds, and as the ratio of new to
old. `--other` has the options that only the other one needs. Exit code 1 if one of them fails.
"""

import argparse
import shlex
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path
from statistics import median

from benchmarks import FOLDER, Measured
from tests.support import programs

SMOKE = "--rounds 1"
SHOWN = frozenset({"p50", "p99", "max", "cpu", "private"})
"""The columns to compare, by the first word of their heads."""
LONGEST_S = 3600.0

Figure = tuple[str, str]


def options(parser: argparse.ArgumentParser) -> None:
    """Add the other checkout, and the benchmark."""
    parser.add_argument(
        "--checkout", type=Path, default=FOLDER.parent, metavar="FOLDER", help="of the other one (default: this one)"
    )
    parser.add_argument("--rounds", type=int, default=5, help="how often each is run (default %(default)s)")
    parser.add_argument("--other", default="", metavar="OPTIONS", help="more options for the other one")
    parser.add_argument("--run", default="turning --smoke", help="a benchmark and its options (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Run both in turns."""
    old, new = defaultdict[Figure, list[float]](list), defaultdict[Figure, list[float]](list)
    name, *words = shlex.split(given.run)
    broken = []
    for turn in range(given.rounds):
        sides = [(given.checkout.resolve(), old, shlex.split(given.other)), (FOLDER.parent, new, [])]
        for checkout, found, more in sides[:: 1 if turn % 2 else -1]:
            code, text = _run(checkout, name, [*words, *more])
            if code:
                broken.append(f"round {turn + 1} of {name} in {checkout} ended with {code}")
            for figure, value in figures(text):
                found[figure].append(value)
            print(f"round {turn + 1}: {checkout}", file=sys.stderr, flush=True)
    return Measured(text=compared(old, new), broken=broken)


def figures(text: str) -> Iterator[tuple[Figure, float]]:
    """Yield each number of the tables in a text by the name of its row and column."""
    head: list[str] = []
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if not line.startswith("|"):
            head = []
        elif not head:
            head = cells
        else:
            for column, cell in zip(head[1:], cells[1:], strict=False):
                if column.replace(",", " ").split(" ")[0].lower() in SHOWN and _is_number(cell):
                    yield (cells[0], column), float(cell)


def compared(old: dict[Figure, list[float]], new: dict[Figure, list[float]]) -> str:
    """Return a table of the common figures."""
    lines = ["| figure | | rounds | old | new | new to old |", "|---|---|--:|--:|--:|--:|"]
    for (name, column), values in old.items():
        if (name, column) in new:
            before, now = median(values), median(new[name, column])
            ratio = f"{now / before:.2f}" if before else ""
            lines.append(f"| {name} | {column} | {len(new[name, column])} | {before:.4g} | {now:.4g} | {ratio} |")
    return "\n".join(lines)


def _run(checkout: Path, name: str, words: Iterable[str]) -> tuple[int, str]:
    whole = (checkout / "benchmarks" / "__main__.py").exists()
    own = checkout / ".venv" / "bin" / "python"
    argv = [
        str(own) if own.exists() else sys.executable,
        "-m",
        *(["benchmarks", name] if whole else [f"benchmarks.{name}"]),
    ]
    done = programs.run([*argv, *words], cwd=checkout, capture_output=True, text=True, timeout=LONGEST_S, check=False)
    sys.stderr.write(done.stderr[-2000:] if done.returncode else "")
    return done.returncode, done.stdout


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
