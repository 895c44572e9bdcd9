"""Scenarios of the benchmarks as tests: hard limits only, because a test machine may be busy."""

from collections.abc import Callable, Iterator

import pytest

from benchmarks.bench import Bench, bench
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
        assert not results.violations()
        assert results.by_figure, "the scenario measured nothing"
        complaints = [*over_their_limit(results), *results.disturbed]
        if not complaints:
            return results
    pytest.fail("; ".join(complaints))


@pytest.fixture(scope="module")
def running() -> Iterator[Bench]:
    """A robot that scenarios of one module share; each begins with results of its own."""
    with bench(Results(PROMISES)) as under_test:
        yield under_test


@pytest.fixture
def held(running: Bench) -> Callable[[Callable[[Bench], None]], Results]:
    """Run a scenario on the shared robot as `holds` does."""

    def run(scenario: Callable[[Bench], None]) -> Results:
        def with_results(results: Results) -> None:
            running.results = results
            scenario(running)
            running.check_limits()

        return holds(with_results)

    return run
