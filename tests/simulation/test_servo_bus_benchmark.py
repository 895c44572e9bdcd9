"""The benchmark of the servo bus catches what must not be: states that were never said, and old ones."""

import pytest

from tests.support.servo_bus.arithmetic import wire_hz
from tests.support.servo_bus.client import Tally
from tests.support.servo_bus.twin import bus


@pytest.fixture
def said():
    """Return what servo 3 answers to this many reads, one after the other."""
    emulated, now = bus(), 100.0

    def read():
        nonlocal now
        emulated.feed(bytes.fromhex("FFFF 03 04 02 24 06 CC"), now)
        now += 0.01
        answer = emulated.poll(now)
        return tuple(answer[at] | answer[at + 1] << 8 for at in (5, 7, 9))

    return read


def judged(*answers):
    tally = Tally()
    for answer in answers:
        tally.take(3, answer, 0, whole=True)
    return tally.states, tally.lost, tally.wrong, tally.stale


def test_states_that_were_said_one_after_the_other_are_right(said):
    assert judged(*(said() for _ in range(2000))) == (2000, 0, 0, 0)


def test_answers_that_got_lost_leave_the_next_ones_right(said):
    answers = [said() for _ in range(20)]
    assert judged(answers[0], None, answers[2], None, None, answers[19]) == (3, 3, 0, 0)


def test_an_old_answer_is_stale(said):
    first, second = said(), said()
    assert judged(first, first)[3] == 1
    assert judged(second, first)[3] == 1


def test_a_wrong_bit_makes_a_state_wrong(said):
    position, speed, load = said()
    assert judged((position ^ 4, speed, load))[2] == 1
    assert judged((speed, load, position))[2] == 1


def test_single_registers_are_judged_too(said):
    tally = Tally()
    for word in range(3):
        tally.take(3, (said()[word],), word, whole=word == 2)
    assert (tally.states, tally.wrong, tally.stale) == (1, 0, 0)
    tally.take(4, (said()[0],), 0, whole=True)
    tally.take(4, (said()[0] + 500,), 0, whole=True)
    assert tally.stale == 1


@pytest.mark.parametrize(
    ("kind", "delay", "least", "most"),
    [
        ("block", 0, 3900, 4100),
        ("block", 250, 1370, 1430),
        ("vendor_three", 0, 1550, 1750),
        ("together", 0, 3550, 3750),
    ],
)
def test_the_line_s_own_limit_is_what_arithmetic_says(kind, delay, least, most):
    assert least < wire_hz(kind, delay) < most
