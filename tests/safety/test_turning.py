"""A base that turns stands as soon as it loses what it turns by or who asked for it, and says why."""

from collections.abc import Iterator

import pytest

from tests.safety.limits import holds
from tests.scenarios import turns
from tests.scenarios.promises import PROMISES
from tests.support.bench import Bench
from tests.support.figures import Results

pytestmark = [pytest.mark.slow_start]


@pytest.fixture(scope="module")
def turning() -> Iterator[Bench]:
    """A robot with an inertial unit, that knows how it lies."""
    with turns.robot_with_attitude(Results(PROMISES)) as under_test:
        yield under_test


@pytest.mark.parametrize("way", turns.WAYS, ids=lambda way: way.__name__)
def test_a_turn_that_loses_what_it_needs_ends_at_rest(turning: Bench, way):
    def scenario(results: Results) -> None:
        turning.results = results
        way(turning)
        turning.check_limits()

    assert holds(scenario).of("S19").n == 1
