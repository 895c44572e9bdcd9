import unicodedata
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.sound import names
from lbr.apps.speech.text import MOST_CHARACTERS, phrase, sayable, to_say
from lbr.errors import InputError
from lbr.messages.speech import Phrase, SayCommand

PHRASES = (
    Phrase(name="hello", language="en", text="Good day."),
    Phrase(name="hello", language="de", text="Guten Tag."),
    Phrase(name="left_turn", language="en", text="Turning."),
    Phrase(name="adieu", language="fr", text="Adieu."),
)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("and/or <b> [[x]]", "and/or <b> [[x]]"),
        ("one\ntwo\tthree\x00\x1b[31m", "one two three[31m"),
        ("well done \U0001f44d\U0001f3fd!", "well done !"),
        ("20 °C, 5 %", "20 °C, 5 %"),
        ("x\u202ey\ufeff", "xy"),
        ("5", "5"),
    ],
)
def test_control_characters_and_pictures_are_left_out(text, said):
    assert sayable(text) == said


@pytest.mark.parametrize("text", ["", "  \n", "\x00\x1b", "\U0001f600\U0001f600", "...", "?!", "\u200d\ufe0f"])
def test_what_leaves_nothing_to_say_is_refused(text):
    with pytest.raises(InputError, match="nothing"):
        sayable(text)


def test_a_text_that_is_too_long_is_refused_with_both_numbers():
    assert len(sayable("a" * MOST_CHARACTERS)) == MOST_CHARACTERS
    with pytest.raises(InputError, match=r"5001 characters; at most 5000 can be spoken"):
        sayable("a" * (MOST_CHARACTERS + 1))


@given(st.text(st.characters(codec=None), max_size=200))
def test_whatever_comes_is_printable_or_refused(text):
    try:
        said = sayable(text)
    except InputError:
        return
    assert said
    assert not {"Cc", "Cs", "Cn"} & {unicodedata.category(char) for char in said}
    said.encode()


@pytest.mark.parametrize(
    ("name", "language", "text"),
    [
        ("hello", "de", "Guten Tag."),
        ("hello", "de-at", "Guten Tag."),
        ("hello", "fr", "Good day."),
        ("adieu", "fr", "Adieu."),
    ],
)
def test_a_phrase_is_said_in_the_language_or_in_english(name, language, text):
    assert phrase(PHRASES, name, language).text == text


def test_an_unknown_phrase_is_refused_with_the_near_ones():
    with pytest.raises(InputError, match=r"no phrase 'left'; did you mean left_turn\?"):
        phrase(PHRASES, "left", "en")
    with pytest.raises(InputError, match=r"no text in 'en'; it has one in fr"):
        phrase(PHRASES, "adieu", "en")
    with pytest.raises(InputError, match="there is none"):
        phrase((), "hello", "en")


def test_a_command_says_a_text_or_a_phrase_in_its_language_or_the_robots():
    assert to_say(SayCommand(text="a"), PHRASES, "en") == ("a", "en")
    assert to_say(SayCommand(text="a", language="DE"), PHRASES, "en") == ("a", "de")
    assert to_say(SayCommand(phrase="hello"), PHRASES, "fr") == ("Good day.", "en")
    with pytest.raises(InputError, match="not both"):
        to_say(SayCommand(text="a", phrase="hello"), PHRASES, "en")


@given(st.text(max_size=80))
def test_a_name_never_leads_out_of_its_folder(name):
    with suppress(InputError):
        assert names.checked(name, "song") == name
        assert "/" not in name
        assert not name.startswith(".")


def test_a_refused_name_is_told_in_one_printable_line():
    with pytest.raises(InputError, match=r"song '\?a': letters"):
        names.checked("\na", "song")
