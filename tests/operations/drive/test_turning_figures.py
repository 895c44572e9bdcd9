"""Turns in the simulated world by the attitude's own fusion, a few of those that `python -m benchmarks turning` measures."""

from tests.models import turning


def test_turns_and_headings_end_where_they_should():
    results = turning.measure(8, seed=2, beside=False)
    assert results.violations() == []
    assert results.of("T3").n == 8
    assert max(results.of("T1").samples + results.of("T2").samples) < 4.0
