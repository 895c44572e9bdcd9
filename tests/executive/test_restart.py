"""The ordered list of restart decisions."""

import pytest

from lbr.executive.processes.restart import ATTEMPTS, MOST_S, WINDOW_S, End, decide


@pytest.mark.parametrize(
    ("policy", "end", "expected"),
    [
        ("never", End.CLEAN, "stopped"),
        ("never", End.CRASHED, "failed"),
        ("never", End.TAKEN, "restart"),
        ("on-failure", End.CLEAN, "stopped"),
        ("on-failure", End.CRASHED, "restart"),
        ("on-failure", End.HUNG, "restart"),
        ("always", End.CLEAN, "restart"),
    ],
)
def test_policy_and_end_decide(policy, end, expected):
    assert decide(policy, end, (), 100.0, 0.0).phase == expected


def test_delay_doubles_and_is_capped():
    delays = [decide("always", End.CRASHED, tuple([99.0] * n), 100.0, 0.0).delay_s for n in range(ATTEMPTS)]
    assert delays == [0.1, 0.2, 0.4, 0.8, 1.6]
    assert all(delay <= MOST_S for delay in delays)


@pytest.mark.parametrize(("jitter", "delay"), [(-1.0, 0.08), (0.0, 0.1), (1.0, 0.12)])
def test_jitter_spreads_restarts_by_a_fifth(jitter, delay):
    assert decide("always", End.CRASHED, (), 100.0, jitter).delay_s == pytest.approx(delay)


def test_gives_up_after_five_ends_within_the_window():
    deaths = tuple(100.0 - n for n in range(ATTEMPTS))
    decision = decide("always", End.CRASHED, deaths, 100.0, 0.0)
    assert decision.phase == "failed"
    assert "given up" in decision.reason


def test_old_ends_do_not_count():
    deaths = tuple(100.0 - WINDOW_S - n for n in range(20))
    assert decide("always", End.CRASHED, deaths, 100.0, 0.0) == decide("always", End.CRASHED, (), 100.0, 0.0)
