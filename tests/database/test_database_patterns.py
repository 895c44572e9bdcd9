"""Patterns of verbs."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.database.patterns import parse


def test_a_path_has_a_word_and_fields():
    pattern = parse("/r/{power}/{angle_deg}")
    assert (pattern.word, pattern.alias, pattern.rest) == ("r", False, False)
    assert pattern.fields == ("power", "angle_deg")


def test_words_and_fields_may_mix():
    pattern = parse("/light/on/{seconds_s}")
    assert pattern.parts == ("on", "{seconds_s}")
    assert pattern.fields == ("seconds_s",)


def test_the_last_field_may_take_the_rest():
    pattern = parse("/s/{text...}")
    assert pattern.rest
    assert pattern.fields == ("text",)


def test_an_alias_is_a_word():
    assert parse("Shutdown").alias
    assert parse("Shutdown").fields == ()


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("/r/{a}/{b}", "/r/{x}/{y}", True),
        ("/r/{a}", "/r/{a}/{b}", False),
        ("/r/{a}", "/r/{a...}", False),
        ("/r/on", "/r/{a}", False),
        ("r", "/r", False),
        ("s", "S", False),
    ],
)
def test_patterns_of_one_shape_take_the_same_lines(one, other, same):
    assert (parse(one).shape == parse(other).shape) is same


@given(st.text(st.sampled_from("/{}.rab_ é0\n") | st.characters(), max_size=30))
def test_parsing_refuses_or_keeps_everything(text):
    try:
        pattern = parse(text)
    except ValueError:
        return
    assert text == (pattern.word if pattern.alias else "/" + "/".join((pattern.word, *pattern.parts)))
    assert len(pattern.fields) == sum(part.startswith("{") for part in pattern.parts)
