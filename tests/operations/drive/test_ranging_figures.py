"""Ranges in the simulated world by the board's own bytes and turns, a few of those that `python -m benchmarks ranges` measures."""

from tests.models import ranging
from tests.support.figures import Results


def test_a_base_rests_within_a_centimetre_of_the_range_at_any_power_ahead_and_back():
    results = Results(ranging.PROMISES)
    off = [off_cm for _, _, off_cm in ranging.measure(results, 1, seed=2, powers=(0.25, 0.8))]
    assert results.violations() == []
    assert len(off) == 18
    assert max(map(abs, off)) <= 2.0
    assert sum(abs(one) <= ranging.NEAR_CM for one in off) >= 17
