"""What a bound is judged by: the share of time that a machine gave, from its own figures."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support import machine
from tests.support.machine import LEAST_SHARE, Look, Stopwatch, share

SECONDS = st.floats(0.0, 1e6)


@pytest.mark.parametrize(
    ("elapsed_s", "waited_s", "stolen_s", "expected"),
    [
        (1.0, 0.0, 0.0, 1.0),
        (2.0, 1.0, 0.0, 0.5),
        (2.0, 0.5, 0.5, 0.5),
        (1.0, 0.99, 0.0, LEAST_SHARE),
        (0.0, 1.0, 0.0, 1.0),
    ],
)
def test_waiting_and_theft_are_taken_off(elapsed_s, waited_s, stolen_s, expected):
    assert share(Look(10.0, 5.0, 3.0), Look(10.0 + elapsed_s, 5.0 + waited_s, 3.0 + stolen_s)) == pytest.approx(
        expected
    )


@given(*[SECONDS] * 6)
def test_no_figures_stretch_a_bound_more_than_fourfold_or_shrink_it(a, b, c, d, e, f):
    assert LEAST_SHARE <= share(Look(a, b, c), Look(d, e, f)) <= 1.0


def test_a_stopwatch_never_counts_more_than_the_clock():
    watch = Stopwatch()
    assert 0.0 <= watch.given_s <= watch.elapsed_s
    assert 1.0 <= machine.slowness() <= machine.SLOWEST


def test_a_kernel_that_says_nothing_withholds_nothing(monkeypatch, tmp_path):
    for name in ("PRESSURE", "DELAY", "STAT"):
        monkeypatch.setattr(machine, name, tmp_path / name)
    assert (machine.waited_s(), machine.stolen_s()) == (0.0, 0.0)


def test_a_hard_promise_is_measured_again_on_a_busy_machine_only_and_tells(monkeypatch):
    monkeypatch.setattr(Stopwatch, "share", 0.5)
    assert list(machine.measure_again(["S1"], times=3)) == [0, 1, 2]
    assert len(machine.notes) == 2
    assert machine.notes[0].startswith("S1: measured again, the machine gave 50% of ")
    monkeypatch.setattr(Stopwatch, "share", 0.95)
    assert list(machine.measure_again(["S1"], times=3)) == [0]
    machine.notes.clear()
