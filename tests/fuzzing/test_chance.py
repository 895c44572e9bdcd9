"""Chance at every way into a robot, a small share of it and from one seed; `python -m benchmarks fuzz` does more."""

import random

import pytest

from tests.fuzzing import bus, console, serial, sockets, walk
from tests.fuzzing.oracle import judge
from tests.fuzzing.promises import PROMISES
from tests.support.figures import Results


@pytest.fixture
def results():
    return Results(PROMISES)


def test_whatever_is_typed_is_judged_as_the_manual_says_and_moves_nothing_else(results):
    console.consoles(results, 120, random.Random(7))
    assert not results.violations()
    assert results.of("Z1").n > 100


def test_whatever_is_thrown_at_the_bus_moves_and_breaks_nothing(results):
    bus.messages(results, 1000, random.Random(7))
    assert not results.violations()
    assert max(results.of("Z4 memory").samples) < PROMISES["Z4 memory"].hard


def test_whatever_a_line_carries_is_never_believed_beyond_what_can_be_measured(results):
    serial.lines(results, 0.2, random.Random(7))
    assert not results.violations()
    assert max(results.of("Z5 frames").samples, default=0) <= PROMISES["Z5 frames"].hard


def test_whatever_happens_one_after_the_other_outputs_are_explained(results):
    walk.walks(results, 1, random.Random(7))
    assert not results.violations()


def test_a_real_handshake_is_what_garbage_is_made_of():
    assert len(sockets.handshake()) > 10


@pytest.mark.parametrize(
    ("line", "verdict"),
    [
        (b"/r/0.5/90", "moves"),
        (b"//r//1./-360", "moves"),
        (b"/r/1.0001/0", "rejected"),
        (b"/r/nan/0", "rejected"),
        (b"/r/1e-1/0", "rejected"),
        (b"/r/0.1/0/10/Forward/3600", "moves"),
        (b"/r/0.1/0/10/above/1", "rejected"),
        (b"  ", "silent"),
        (b"# so", "silent"),
        (b"clock 'x", "rejected"),
        (b"!1", "rejected"),
        (b"\xff", "rejected"),
        (b"STOP", "taken"),
        (b"shutdown", "rejected"),
        (b"Shutdown", "shutdown"),
    ],
)
def test_the_model_of_the_console_knows_the_manual(line, verdict):
    assert judge(line, ("clock",), piped=True) == verdict
