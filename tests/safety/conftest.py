"""Scenarios of the benchmarks as tests: hard limits only, because a test machine may be busy."""

from collections.abc import Callable, Iterator

import pytest

from tests.safety.limits import holds
from tests.scenarios.promises import PROMISES
from tests.support.bench import Bench, bench
from tests.support.figures import Results


@pytest.fixture(scope="package")
def running() -> Iterator[Bench]:
    """A robot that all scenarios share that leave it standing; each begins with results of its own."""
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
