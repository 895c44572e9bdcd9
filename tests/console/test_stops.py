"""Which lines are stops, and that each of them is one to the robot, too."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.console.keyboard import Overhearing
from lbr.console.operator import emergency
from lbr.console.stops import STOPS, stop_in
from lbr.console.verbs import VerbCall, Vocabulary

ROBOT = Vocabulary(())
UNSEEN = st.text(st.sampled_from(" \t\r\n\x00\x07\x1b\u00a0\u2003\ufeff\u200b\u2060\u200f\u202e/\uff0f"), max_size=80)


def wide(word: str) -> str:
    return "".join(chr(ord(letter) + 0xFEE0) for letter in word)


@pytest.mark.parametrize(
    ("line", "stop"),
    [
        (b"s", "s"),
        ("S", "s"),
        ("s/", "s"),
        ("s /", "s"),
        ("/stop", "stop"),
        ("//s// ", "s"),
        (b"  STOP\n", "stop"),
        ("estop", "estop"),
        ("/estop/it burns", "/estop/it burns"),
        ("ESTOP/it burns", "/estop/it burns"),
        ("estop/a\x07bell", "/estop/a bell"),
        (" " * 99 + "stop", "stop"),
        ("/" * 99 + "stop", "stop"),
        ("\ufeffstop\u200b", "stop"),
        (b"stop\0", "stop"),
        (wide("estop"), "estop"),
        (wide("/estop/") + "x", "/estop/x"),
        (b"\xff", ""),
        ("/s/Hello", ""),
        ("stop navcam", ""),
        ("/stop/it", ""),
        ("/s/\udcff", ""),
        ("/estop/\udcff", "estop"),
        ("s\u0301", ""),
        ("s top", ""),
        ("", ""),
        ("/" * 9, ""),
    ],
)
def test_a_line_is_a_stop_or_it_is_not(line, stop):
    assert stop_in(line) == stop


@given(UNSEEN, st.sampled_from(sorted(STOPS)), UNSEEN, st.sampled_from([str, str.upper, wide]))
def test_a_stop_in_whatever_nobody_sees_is_one_to_the_robot(before, word, after, letters):
    said = stop_in(before + letters(word) + after)
    assert said == word
    call = ROBOT.parse(said)
    assert isinstance(call, VerbCall)
    assert call.command == ("estop" if word == "estop" else "stop")


@given(st.text(max_size=5000))
def test_an_emergency_stop_may_give_any_reason(reason):
    said = stop_in(f"/estop/{reason}")
    assert isinstance(ROBOT.parse(said), VerbCall)
    assert emergency(said) is not None


@given(st.text(max_size=40) | st.binary(max_size=40))
def test_what_is_no_stop_is_left_as_it_is_and_a_stop_stays_one(line):
    said = stop_in(line)
    assert stop_in(said) == said


@pytest.mark.parametrize("word", ["s", "S", "stop", "STOP", "estop", "/s", "/stop"])
@pytest.mark.parametrize("remains", ["[20;1R", "\x1b[20;1R", "[A", "[", "[2", "[20;1R[20;1R", "[?1;2c", "[<0;3;4M"])
def test_a_stop_word_with_remains_of_a_terminals_sequence_is_that_stop(word, remains):
    assert stop_in(word + remains) == stop_in(word) != ""


def test_two_hundred_stops_through_a_terminal_that_is_cut_at_every_byte_are_two_hundred():
    heard: list[str] = []
    now = 0.0
    overhearing = Overhearing(lambda: now)
    for turn in range(200):
        gap_s = turn % 11 / 10
        for character in ("s" if turn % 2 else "estop") + "\x1b[20;1R\r":
            now += gap_s
            heard += overhearing.hear(character).stops
    assert heard == ["estop", "s"] * 100
