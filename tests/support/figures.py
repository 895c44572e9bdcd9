"""What was measured, against what was promised: samples, percentiles, violations, verdicts, a table."""

import math
import os
import platform
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

import msgspec
from msgspec import Struct, field, structs

Verdict = Literal["met", "missed", "broken"]
Statistic = Literal["max", "p99", "p95", "p50"]
STATISTICS: tuple[Statistic, ...] = ("p50", "p99", "max")


BASE, WHOLE = "base", "whole"
"""Which robot was measured: motors, ranges, drive and world of lbr, or lbr as it ships."""


class Promise(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A figure: `target` is graded by `statistic`, `hard` by the maximum; a violation breaks it whatever the time.

    `robot` is what ran; empty where none did, or where `what` says it.
    """

    what: str
    unit: str = "ms"
    target: float | None = None
    statistic: Statistic = "max"
    hard: float | None = None
    robot: str = ""


class Result(Struct, kw_only=True):
    """Everything measured for one figure."""

    figure: str
    promise: Promise
    samples: list[float] = field(default_factory=list)
    checks: int = 0
    violations: list[str] = field(default_factory=list)

    @property
    def n(self) -> int:
        """How often it was tried."""
        return max(len(self.samples), self.checks)

    @property
    def verdict(self) -> Verdict:
        """`broken`: a hard value or a zero-tolerance check; `missed`: only the graded target."""
        promise, worst = self.promise, max(self.samples, default=0.0)
        if self.violations or self.n == 0 or (promise.hard is not None and not worst <= promise.hard):
            return "broken"
        if promise.target is None or not self.samples:
            return "met"
        return "met" if percentile(self.samples, promise.statistic) <= promise.target else "missed"


class Report(Struct, kw_only=True):
    """A run of the benchmark, and where it ran."""

    machine: str
    load: str
    started: str
    took_s: float
    results: list[Result]
    repeated: list[str] = []
    disturbed: list[str] = []
    figures: dict[str, Any] = {}
    """What no promise grades."""

    def write(self, path: Path) -> None:
        """Write it as JSON, one figure to a line."""
        path.write_bytes(msgspec.json.encode(self).replace(b'{"figure"', b'\n{"figure"') + b"\n")

    def tell_broken(self) -> int:
        """Say on standard error what is broken; return the exit code."""
        broken = [result for result in self.results if result.verdict == "broken"]
        for result in broken:
            for text in result.violations[:5] or ["above its hard limit"]:
                print(f"BROKEN {result.figure}: {text}", file=sys.stderr)
        return 1 if broken else 0

    def tell_repeated(self) -> None:
        """Say on standard error what counts although it was not the first try, and what does not count."""
        for title, texts in (("measured again", self.repeated), ("not counted", self.disturbed)):
            for text, times in Counter(texts).items():
                print(f"{title}: {text}{f' ({times} times)' if times > 1 else ''}", file=sys.stderr)


def machine() -> str:
    """Return what this machine is."""
    python = sys.version.split()[0]
    return f"{os.cpu_count()} cores, {platform.machine()}, Linux {platform.release()}, Python {python}"


class Results:
    """Collects what scenarios measure, by figure, on the base or on whole robots.

    `disturbed` are tries that do not count, because nothing moved before the fault; `repeated` says what was tried again.
    """

    def __init__(self, promises: dict[str, Promise], *, whole: bool = False) -> None:
        self.by_figure: dict[str, Result] = {}
        self.disturbed: list[str] = []
        self.repeated: list[str] = []
        self.promises = promises
        self.whole = whole

    def of(self, figure: str) -> Result:
        """Return the result of a figure, empty at first."""
        if figure not in self.by_figure:
            promise = self.promises[figure]
            if self.whole and promise.robot == BASE:
                promise = structs.replace(promise, robot=WHOLE)
            self.by_figure[figure] = Result(figure=figure, promise=promise)
        return self.by_figure[figure]

    def sample(self, figure: str, value: float) -> None:
        """Take in a measured value."""
        self.of(figure).samples.append(round(value, 3))

    def check(self, figure: str, problems: Iterable[str] = ()) -> None:
        """Take in a check that must never fail, with what was wrong."""
        result = self.of(figure)
        result.checks += 1
        result.violations += problems

    def under(self, load: str) -> "Results":
        """Return a view for scenarios under a load: `S1` counts as `S1 H`; a time that has no such figure is let go."""
        return _Loaded(self, load)

    def add(self, results: Iterable[Result], disturbed: Iterable[str] = (), repeated: Iterable[str] = ()) -> None:
        """Take in what was measured elsewhere."""
        for found in results:
            own = self.by_figure.setdefault(found.figure, Result(figure=found.figure, promise=found.promise))
            own.samples += found.samples
            own.checks += found.checks
            own.violations += found.violations
        self.disturbed += disturbed
        self.repeated += repeated

    def ordered(self) -> list[Result]:
        """Return the results in the order of the promises."""
        return [self.by_figure[figure] for figure in self.promises if figure in self.by_figure]

    def violations(self) -> list[str]:
        """Return everything that must not have been."""
        return [f"{result.figure}: {text}" for result in self.by_figure.values() for text in result.violations]


class _Loaded(Results):
    def __init__(self, results: Results, load: str) -> None:
        super().__init__(results.promises, whole=results.whole)
        self.disturbed = results.disturbed
        self.repeated = results.repeated
        self._results = results
        self._load = load

    def of(self, figure: str) -> Result:
        for name in (f"{figure} {self._load}", figure):
            promise = self.promises.get(name)
            if promise is not None and (name != figure or (promise.target is None and promise.hard is None)):
                return self._results.of(name)
        return super().of(figure)


def percentile(samples: list[float], statistic: Statistic) -> float:
    """Return a percentile of what was measured, the nearest one above; NaN of nothing."""
    if not samples:
        return math.nan
    if statistic == "max":
        return max(samples)
    share = int(statistic[1:]) / 100
    return sorted(samples)[max(0, math.ceil(share * len(samples)) - 1)]


def slope(points: list[tuple[float, float]]) -> float:
    """Return the slope of the line of least squares."""
    n = len(points)
    x, y = sum(at for at, _ in points) / n, sum(value for _, value in points) / n
    spread = sum((at - x) ** 2 for at, _ in points)
    return sum((at - x) * (value - y) for at, value in points) / spread if spread else 0.0


def table(results: Iterable[Result]) -> str:
    """Return a Markdown table, one row for each figure."""
    return rows(summary(result) for result in results)


class Summary(Struct, kw_only=True, omit_defaults=True):
    """What is kept of a figure: few enough numbers to read; `measured` says when, on what, beside what."""

    figure: str
    promise: Promise
    n: int
    verdict: Verdict
    p50: float | None = None
    p99: float | None = None
    max: float | None = None
    failures: int = 0
    example: str = ""
    measured: str = ""


def summary(result: Result, measured: str = "") -> Summary:
    """Return what is kept of a result."""
    samples = result.samples
    p50, p99, most = (round(percentile(samples, s), 3) if samples else None for s in STATISTICS)
    return Summary(
        figure=result.figure,
        promise=result.promise,
        n=result.n,
        verdict=result.verdict,
        p50=p50,
        p99=p99,
        max=most,
        failures=len(result.violations) + _too_long(result),
        example=result.violations[0][:200] if result.violations else "",
        measured=measured,
    )


def rows(summaries: Iterable[Summary]) -> str:
    """Return a Markdown table: milliseconds and motor zero go without saying, and so does a verdict that is met."""
    head = ("figure", "what", "robot", "N", "p50", "p99", "max", "target", "hard", "verdict")
    lines = ["|" + "|".join(head) + "|", "|---|---|---|--:|--:|--:|--:|---|---|---|"]
    before, figure_by_what = "", dict[str, str]()
    for found in summaries:
        promise = found.promise
        what = promise.what.removesuffix(", to motor zero")
        numbers = ["" if value is None else _number(value) for value in (found.p50, found.p99, found.max)]
        unit = "" if promise.unit == "ms" else f" {promise.unit}"
        target = f"{promise.statistic} {promise.target:g}{unit}" if promise.target is not None else ""
        zero = "" if found.max is not None else "none"
        hard = f"{promise.hard:g}{unit}" if promise.hard is not None else zero
        cells = [
            found.figure,
            "" if what == before else _unrepeated(what, before, figure_by_what.get(what)),
            promise.robot,
            str(found.n),
            *numbers,
            target.strip(),
            hard.strip(),
        ]
        verdict = "" if found.verdict == "met" else found.verdict
        cells += [verdict + (f": {found.failures} of {found.n}" if found.failures else "")]
        lines.append("|" + "|".join(cells) + "|")
        before = what
        figure_by_what.setdefault(what, found.figure)
    return "\n".join(lines)


def _unrepeated(what: str, before: str, explained_at: str | None) -> str:
    """Return a row's description: the figure that has the same one, or without the first words if the row above has them."""
    if explained_at:
        return f"as {explained_at}"
    words, above = what.split(), before.split()
    shared = next((place for place, pair in enumerate(zip(words, above, strict=False)) if pair[0] != pair[1]), 0)
    return f"… {' '.join(words[shared:])}" if shared > 3 else what


def _too_long(result: Result) -> int:
    hard = result.promise.hard
    return 0 if hard is None else sum(not value <= hard for value in result.samples)


def _number(value: float) -> str:
    return f"{value:.1f}" if abs(value) < 100 else f"{value:.0f}"
