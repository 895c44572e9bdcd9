"""The words of a robot as methods: what they say, what completes, what is refused before it is said."""

import inspect

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.client import InputError, Words

ENTRIES = [
    {"word": "r", "pattern": "/r/{power}/{angle}", "help": "Drive.", "target": "drive.command",
     "fields": [{"name": "power", "choices": []}, {"name": "angle", "choices": []}]},
    {"word": "r", "pattern": "/r/{power}", "help": "Ahead.", "target": "drive.command", "fields": [{"name": "power", "choices": []}]},
    {"word": "s", "pattern": "/s/{text...}", "help": "Speak.", "target": "speech.say", "fields": [{"name": "text", "choices": []}]},
    {"word": "autodock", "pattern": "autodock", "help": "Dock.", "target": "external", "fields": []},
    {"word": "play", "pattern": "/play/{motion}", "help": "Play.", "target": "motions.play", "fields": [{"name": "motion", "choices": ["bow", "wave"]}]},
    {"word": "import", "pattern": "import", "help": "A keyword of Python's.", "target": "own.x", "fields": []},
    {"word": "odd", "pattern": "/odd/{class}/{a-b}", "help": "", "target": "x.y", "fields": [{"name": "class"}, {"name": "a-b"}]},
]  # fmt: skip


@pytest.fixture
def words():
    return Words(lambda: ENTRIES, lambda line: line)


def test_words_complete_and_tell_what_they_take(words):
    assert dir(words) == ["autodock", "odd", "play", "r", "s"]
    assert str(inspect.signature(words.r)) == "(power, angle=None, /)"
    assert words.r.__name__ == "r"
    assert words.r.__doc__ == "/r/{power}/{angle}: Drive.\n/r/{power}: Ahead."
    assert "motion: bow, wave" in words.play.__doc__
    assert len(inspect.signature(words.odd).parameters) == 2


def test_they_say_what_is_typed_at_the_console(words):
    assert words.r(0.5, -90) == "/r/0.5/-90"
    assert words.s("either/or, said at once") == "/s/either/or, said at once"
    assert (words.autodock(), words["autodock"]("slow")) == ("autodock", "autodock slow")
    assert words["import"]() == "import"


@given(st.text(max_size=9))
def test_no_value_becomes_another_field_or_another_line(value):
    words = Words(lambda: ENTRIES, lambda line: line)
    try:
        line = words.play(value)
    except InputError:
        assert "/" in value or not value.strip() or not value.isprintable()
    else:
        assert line == f"/play/{value}"
        assert line.count("/") == 2


def test_a_word_that_is_not_there_is_asked_for_again_and_then_told():
    asked = []
    words = Words(lambda: asked.append(1) or ENTRIES[len(asked) :], lambda line: line)
    with pytest.raises(AttributeError, match="'nod' is not a word of this robot"):
        _ = words.nod
    with pytest.raises(KeyError):
        words["nod"]
    assert len(asked) == 2
    assert not hasattr(words, "_ipython_display_")
    assert len(asked) == 2
