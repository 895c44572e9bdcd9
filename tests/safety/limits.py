"""What a scenario may never show, on however busy a machine."""

from collections.abc import Callable

import pytest

from benchmarks.figures import Results
from benchmarks.promises import PROMISES

TRIES = 2
GRADED = ("S13 gone", "S13 ready", "P1 motors", "P1 drive", "P5 gone", "P5 ready", "P6", "P8 edit", "S18 interval")
"""Times that a busy machine may stretch without anybody being hurt."""


def over_their_limit(results: Results) -> list[str]:
    """Return the stops and ends that took longer than they ever may."""
    return [
        f"{result.figure}: {max(result.samples):.0f} ms, at most {result.promise.hard:g} ms"
        for result in results.by_figure.values()
        if result.samples and result.promise.hard is not None and result.figure not in GRADED
        if not max(result.samples) <= result.promise.hard
    ]


def holds(scenario: Callable[[Results], None]) -> Results:
    """Run a scenario and fail on what must never be; one that a busy machine made late or spoiled is tried again."""
    complaints: list[str] = []
    for _ in range(TRIES):
        results = Results(PROMISES)
        scenario(results)
        assert not results.violations(), results.violations()
        assert results.by_figure, "the scenario measured nothing"
        complaints = [*over_their_limit(results), *results.disturbed]
        if not complaints:
            return results
    pytest.fail("; ".join(complaints))
