"""However whoever drives goes, the motors stand and stay so."""

from collections.abc import Callable

import pytest

from tests.scenarios import clients
from tests.support.bench import Bench
from tests.support.figures import Results


@pytest.mark.parametrize("way", clients.WAYS, ids=lambda way: way.__name__)
def test_a_client_that_is_gone_moves_nothing(held: Callable[[Callable[[Bench], None]], Results], way):
    results = held(lambda under_test: under_test.once_it_moves(way))
    assert results.of("S8").n + results.of("S8 clean").n == 1
