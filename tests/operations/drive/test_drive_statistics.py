"""The beat of the loop, and what is said of it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.operations.statistics import Beat, LoopMeter


def test_statistics_name_rate_worst_period_and_overruns():
    meter, now, found = LoopMeter(50.0), 0.0, None
    assert meter.round(now) is None
    for period_s in [0.02] * 46 + [0.05, 0.04]:
        now += period_s
        found = meter.round(now)
    assert found.rate_hz == pytest.approx(48 / 1.01, abs=0.01)
    assert (found.period_max_ms, found.period_p99_ms, found.overruns) == (50.0, 50.0, 2)


def test_each_window_counts_its_own_rounds():
    meter, windows = LoopMeter(50.0), []
    for step in range(200):
        found = meter.round(step * 0.02 + (0.5 if step > 20 else 0.0))
        windows += [found] if found else []
    assert [window.overruns for window in windows] == [1, 0, 0, 0][: len(windows)]


@given(st.lists(st.floats(0.0, 0.0019), min_size=400, max_size=400))
def test_waking_a_little_late_loses_no_round(jitter_s):
    beat = Beat(50.0)
    assert sum(beat.due(step * 0.02 + late_s) for step, late_s in enumerate(jitter_s)) >= 398


@given(st.lists(st.floats(0.0, 0.1), min_size=50, max_size=300))
def test_being_woken_too_often_adds_no_round(gaps_s):
    beat, now, rounds = Beat(50.0), 0.0, 0
    for gap_s in gaps_s:
        now += gap_s
        rounds += beat.due(now)
    assert rounds <= now * 50.0 + 2


@given(st.floats(0.0, 0.009))
def test_a_late_first_round_costs_one_round_at_most(first_late_s):
    beat = Beat(50.0)
    assert sum(beat.due(step * 0.02 + (first_late_s if step == 0 else 0.0)) for step in range(400)) >= 399
