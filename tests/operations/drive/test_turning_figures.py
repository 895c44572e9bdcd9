"""Turns in the simulated world by the attitude's own fusion, a few of those that `python -m benchmarks.turning` measures."""

import pytest

from benchmarks import turning


@pytest.mark.parametrize("seed", [1, 2])
def test_turns_and_headings_end_where_they_should(seed):
    results = turning.measure(8, seed, beside=False)
    assert results.violations() == []
    assert results.of("T3").n == 8
    assert max(results.of("T1").samples + results.of("T2").samples) < 4.0
