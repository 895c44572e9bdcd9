from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.mqtt.echo import CALM_S, EVERY_S, LATE_S, MOST_UNDER_WAY, Echo

STEP_S = 0.05


def echo_at(now):
    echo = Echo()
    echo.connected(now)
    return echo


def test_nothing_is_believed_before_a_broker_was_reached():
    assert Echo().late(0.0)


def test_a_broker_that_sends_back_at_once_is_not_late():
    echo = echo_at(100.0)
    for turn in range(1000):
        now = 100.0 + turn * STEP_S
        if word := echo.word(now):
            echo.receive(word.encode(), now + 0.3)
        assert not echo.late(now)


def test_a_word_goes_once_a_second():
    echo = echo_at(0.0)
    assert sum(bool(echo.word(turn * STEP_S)) for turn in range(round(60 / STEP_S))) == 60 / EVERY_S


@given(
    still_s=st.floats(min_value=LATE_S + 2 * EVERY_S, max_value=600.0),
    asked_after=st.integers(min_value=0, max_value=20),
    begins_s=st.floats(min_value=0.0, max_value=EVERY_S),
)
def test_what_a_standstill_held_back_is_late_wherever_it_comes_among_our_words(still_s, asked_after, begins_s):
    echo = echo_at(0.0)
    first = echo.word(0.0)
    echo.receive(first.encode(), 0.0)
    now, held = begins_s, []
    while now < begins_s + still_s:
        held += [word for word in [echo.word(now)] if word]
        now += EVERY_S / 4
    for number, word in enumerate([*held, ""]):
        if number == min(asked_after, len(held)):
            assert echo.late(now + number * 0.001)
        echo.receive(word.encode(), now + number * 0.001)
    assert not echo.stands_still(now + 0.1)
    for turn in range(round((CALM_S + EVERY_S) / STEP_S)):
        echo.receive(echo.word(now + turn * STEP_S).encode(), now + turn * STEP_S + 0.01)
    assert not echo.late(now + CALM_S + EVERY_S)


def test_a_broker_that_sends_nothing_back_is_late_and_costs_no_memory():
    echo = echo_at(0.0)
    for turn in range(100_000):
        echo.word(turn * EVERY_S)
    assert echo.stands_still(100_000.0)
    assert len(echo._sent) <= MOST_UNDER_WAY


@given(st.lists(st.binary(max_size=40)))
def test_words_of_others_and_of_an_earlier_connection_say_nothing(payloads):
    echo = echo_at(0.0)
    earlier = echo.word(0.0)
    echo.connected(10.0)
    for payload in [earlier.encode(), *payloads]:
        echo.receive(payload, 10.0 + LATE_S + EVERY_S + 0.1)
    assert echo.stands_still(10.0 + LATE_S + EVERY_S + 0.1)


def test_a_word_that_comes_back_twice_counts_once():
    echo = echo_at(0.0)
    word = echo.word(0.0).encode()
    echo.receive(word, 0.1)
    echo.receive(word, 0.1 + LATE_S + EVERY_S)
    assert echo.stands_still(0.2 + LATE_S + EVERY_S)
