"""Somebody steps in the way: world, board, parser and kernel in lockstep, as `python -m benchmarks approach` does at length."""

import pytest

from lbr.operations.drive.settings import DriveSettings
from tests.models.approach import PROMISES, failing, run, trials
from tests.models.lockstep import corners, gap_m
from tests.support.figures import Results


@pytest.mark.parametrize("side", ["forward", "back"])
def test_nobody_who_steps_in_the_way_is_touched(side):
    outcomes = [run(trial, DriveSettings()) for trial in trials(side, 8, seed=7)]
    assert not any(outcome.contact for outcome in outcomes)
    assert all(outcome.stopped for outcome in outcomes)
    assert min(outcome.closest_m for outcome in outcomes) > 0.05


def test_the_same_seed_gives_the_same_approach():
    first, second = (run(next(trials("forward", 1, seed=3)), DriveSettings()) for _ in range(2))
    assert first == second


def test_a_broken_sensor_stops_the_motion_towards_it():
    results = Results(PROMISES)
    failing(results, 1, 5, DriveSettings())
    assert len(results.by_figure) == 8
    assert not results.violations()
    assert all(result.verdict != "broken" for result in results.by_figure.values())


def test_how_far_two_outlines_are_apart():
    one = corners(0.0, 0.0, 0.0, 2.0, 2.0)
    assert gap_m(one, corners(3.0, 0.0, 0.0, 2.0, 2.0)) == pytest.approx(1.0)
    assert gap_m(one, corners(3.0, 0.0, 0.785398163, 2.0, 2.0)) == pytest.approx(2.0 - 2**0.5)
    assert gap_m(one, corners(1.5, 1.5, 0.4, 2.0, 2.0)) == 0.0
