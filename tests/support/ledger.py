"""The newest result of every figure, from all benchmarks: a small file, and the table in benchmarks/figures.md."""

from pathlib import Path

import msgspec
from msgspec import Struct

from tests.support.figures import Report, Summary, rows, summary

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "benchmarks" / "figures.md"
RESULTS = ROOT / "benchmarks" / "results.json"
BEGIN, END = "<!-- figures:begin -->", "<!-- figures:end -->"
FAMILIES = "SEFTPDZABK"
ABOUT = """Times are in milliseconds and run to motor zero, unless the figure says otherwise. *Target* is graded, *hard* may never be
passed; *none*: no violation is allowed. Without a verdict a figure is met. N tries without a failure leave 3/N possible
(95 %). *Robot*: *base* has the capabilities motors, ranges, drive and world of lbr-sim, *whole* is lbr-sim as it ships;
empty: no robot, or the base with the named part. Load by the figure's name: *H* four busy loops, *G* these and floods of
20,000 messages, *clock* a wall clock that jumps. [results.json](results.json) has the machine, the time and
the load of each, [anchors.py](../tests/support/anchors.py) the best figures known of others."""


class Ledger(Struct, kw_only=True):
    """Figures by family and number."""

    figures: list[Summary] = []

    @classmethod
    def read(cls, path: Path = RESULTS) -> "Ledger":
        """Return what is kept; nothing if there is no such file."""
        return msgspec.json.decode(path.read_bytes(), type=cls) if path.exists() else cls()

    def merge(self, report: Report) -> None:
        """Take in a report: what it has measured again replaces what was there."""
        again = f"; {len(report.repeated)} measured again" if report.repeated else ""
        measured = f"{report.started} on {report.machine}; {report.load}{again}"
        new = [summary(result, measured) for result in report.results]
        names = {found.figure for found in new}
        self.figures = sorted([*(old for old in self.figures if old.figure not in names), *new], key=_order)

    def write(self, path: Path = RESULTS) -> None:
        """Write one figure to a line."""
        lines = b",\n".join(msgspec.json.encode(found) for found in self.figures)
        path.write_bytes(b'{"figures": [\n' + lines + b"\n]}\n")

    def write_docs(self, path: Path = DOCS) -> None:
        """Put the table between its markers; raise ValueError if they are not there."""
        head, begin, rest = path.read_text().partition(BEGIN)
        _, end, tail = rest.partition(END)
        if not (begin and end):
            raise ValueError(f"{path} has no {BEGIN} … {END}")
        path.write_text(f"{head}{BEGIN}\n{ABOUT}\n\n{rows(self.figures)}\n{END}{tail}")


def _order(found: Summary) -> tuple[int, int, str]:
    name = found.figure.split()[0]
    family, number = name[0], name[1:]
    return (FAMILIES.find(family) % 99, int(number) if number.isdigit() else 0, found.figure)
