"""When what would hear a stop is taken for deaf, and when a terminal is taken for gone."""

import pytest

from lbr.console.ear import ANSWER_S, ASK_S, FRESH_S, Contact, Ear


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock():
    return Clock()


def test_an_ear_that_beats_hears(clock):
    ear = Ear(clock=clock)
    for _ in range(20):
        clock.now += FRESH_S / 2
        ear.beat()
        assert ear.deaf(0.0) == ""


def test_an_ear_without_a_pulse_is_deaf_until_it_beats(clock, wording):
    ear = Ear(clock=clock)
    clock.now = FRESH_S + 0.01
    wording(ear.deaf(0.0))
    ear.beat()
    assert ear.deaf(0.0) == ""


def test_what_begins_now_gives_the_pulse_its_time(clock):
    ear = Ear(clock=clock)
    clock.now = 10.0
    assert ear.deaf(10.0) == ""
    clock.now += FRESH_S + 0.01
    assert ear.deaf(10.0)


def test_a_clock_that_is_no_number_is_no_pulse(clock):
    ear = Ear(clock=clock)
    clock.now = float("nan")
    assert ear.deaf(0.0)


def test_a_terminal_is_asked_once_and_never_again_if_it_does_not_answer(clock):
    contact = Contact(clock)
    assert contact.due(held=False)
    contact.asked()
    for _ in range(100):
        clock.now += ANSWER_S
        assert not contact.due(held=True)
        assert contact.lost() == ""


def test_a_terminal_that_answers_is_asked_while_something_is_held(clock):
    contact = Contact(clock)
    contact.asked()
    contact.answered()
    clock.now = ASK_S
    assert not contact.due(held=False)
    assert contact.due(held=True)
    contact.asked()
    clock.now += ASK_S
    assert not contact.due(held=True)  # one question at a time


def test_a_terminal_that_ceases_to_answer_is_lost_until_it_answers(clock):
    contact = Contact(clock)
    contact.asked()
    contact.answered()
    contact.asked()
    clock.now = ANSWER_S
    assert contact.lost() == ""
    clock.now = ANSWER_S + 0.01
    assert "has not answered" in contact.lost()
    contact.answered()
    assert contact.lost() == ""


def test_a_line_typed_gives_a_lost_terminal_one_more_question(clock):
    contact = Contact(clock)
    contact.asked()
    contact.answered()
    contact.asked()
    clock.now = 5.0
    assert contact.lost()
    assert not contact.due(held=True)
    contact.typed()
    assert contact.lost() == ""
    assert contact.due(held=True)
    contact.asked()
    clock.now += ANSWER_S + 0.01
    assert contact.lost()
