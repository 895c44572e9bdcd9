"""What was measured, against what was promised: samples, percentiles, violations, verdicts, a table."""

import math
from collections.abc import Iterable
from typing import Literal

from msgspec import Struct, field

Verdict = Literal["met", "missed", "broken"]
Statistic = Literal["max", "p99", "p95", "p50"]


class Promise(Struct, frozen=True, kw_only=True):
    """A figure: `target` is graded by `statistic`, `hard` by the maximum; a violation breaks it whatever the time."""

    what: str
    unit: str = "ms"
    target: float | None = None
    statistic: Statistic = "max"
    hard: float | None = None


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


class Results:
    """Collects what scenarios measure, by figure; `disturbed` are tries in which nothing moved before the fault."""

    def __init__(self, promises: dict[str, Promise]) -> None:
        self.by_figure: dict[str, Result] = {}
        self.disturbed: list[str] = []
        self.promises = promises

    def of(self, figure: str) -> Result:
        """Return the result of a figure, empty at first."""
        if figure not in self.by_figure:
            self.by_figure[figure] = Result(figure=figure, promise=self.promises[figure])
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

    def violations(self) -> list[str]:
        """Return everything that must not have been."""
        return [f"{result.figure}: {text}" for result in self.by_figure.values() for text in result.violations]


class _Loaded(Results):
    def __init__(self, results: Results, load: str) -> None:
        super().__init__(results.promises)
        self.disturbed = results.disturbed
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


def table(results: Iterable[Result]) -> str:
    """Return a Markdown table, one row for each figure."""
    rows = [
        "| figure | what | N | p50 | p99 | max | target | hard | verdict |",
        "|---|---|--:|--:|--:|--:|---|---|---|",
    ]
    for result in results:
        promise, samples = result.promise, result.samples
        cells = [_number(percentile(samples, s)) if samples else "" for s in ("p50", "p99", "max")]
        target = f"{promise.statistic} {promise.target:g} {promise.unit}" if promise.target is not None else ""
        hard = f"{promise.hard:g} {promise.unit}" if promise.hard is not None else "" if samples else "0 violations"
        verdict = result.verdict + (f": {len(result.violations)} of {result.n}" if result.violations else "")
        rows.append(
            "| " + " | ".join([result.figure, promise.what, str(result.n), *cells, target, hard, verdict]) + " |"
        )
    return "\n".join(rows)


def _number(value: float) -> str:
    return f"{value:.1f}" if abs(value) < 100 else f"{value:.0f}"
