"""The newest result of every figure, from all benchmarks: a small file, and the table in docs/reference/figures.md."""

from collections.abc import Iterable
from pathlib import Path

import msgspec
from msgspec import Struct

from tests.support.anchors import anchor
from tests.support.figures import Report, Summary, rows, summary

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs" / "reference" / "figures.md"
RESULTS = ROOT / "benchmarks" / "results.json"
BEGIN, END = "<!-- figures:begin -->", "<!-- figures:end -->"
FAMILIES = "SEFTPDZABK"
ABOUT = """Times are in milliseconds unless the target says otherwise. *Target* is graded, *hard* may never be passed, *fails
at most* is what this many tries without a failure leave possible (3/N, 95 %), *anchor* is the best figure known of others.
*Robot* is what ran: *base* are the capabilities motors, ranges, drive and world of lbr-sim and no others, *whole* is
lbr-sim as it ships; where it is empty, no robot ran, or the base with what the line is about.
Load: *I* nothing else, *H* four busy loops, *G* these and floods of 20,000 messages, *clock* a wall clock that jumps.

`python -m benchmarks safety --gate` tries all of it in under five minutes, as CI does; `--full --minutes 120` measures in
rounds as much as fits, `--whole` on whole robots. `python -m benchmarks soak --minutes 30` lets a robot live, with a fault a minute. What any
benchmark writes with `--json FILE` gets into this table by `python -m benchmarks safety --merge FILE --write-docs`."""


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
        measured = "\n".join(f"- {text}" for text in _occasions(self.figures))
        path.write_text(
            f"{head}{BEGIN}\n{ABOUT}\n\n{rows(self.figures, anchor)}\n\nMeasured:\n\n{measured}\n{END}{tail}"
        )


def _occasions(figures: Iterable[Summary]) -> list[str]:
    """Return when, where and beside what, with the figures that were measured then."""
    found: dict[str, list[str]] = {}
    for figure in figures:
        found.setdefault(figure.measured, []).append(figure.figure.split()[0])
    return [f"{', '.join(dict.fromkeys(names))}: {measured}" for measured, names in found.items()]


def _order(found: Summary) -> tuple[int, int, str]:
    name = found.figure.split()[0]
    family, number = name[0], name[1:]
    return (FAMILIES.find(family) % 99, int(number) if number.isdigit() else 0, found.figure)
