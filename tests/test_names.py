"""Which name may have been meant and which is free: whatever is typed, an answer comes, and a short one."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.messages.units import NAME_PATTERN
from lbr.names import LONGEST, MOST_TOLD, did_you_mean, first_free, name_from, near

NAMES = st.text("abcdefghij_", min_size=1, max_size=12)


@given(st.text(max_size=200), st.lists(NAMES, max_size=30))
def test_only_names_that_there_are_are_told_and_not_too_many(name, known):
    said = did_you_mean(name, known)
    if not known:
        assert said == "there is none"
        return
    _, _, told = said.removesuffix("?").removesuffix(", …").replace("did you mean", "there are").partition("there ")
    words = told.partition(" ")[2].replace(" or ", ", ").split(", ")
    assert set(words) <= set(known)
    assert 1 <= len(words) <= MOST_TOLD


@given(NAMES, st.lists(NAMES, max_size=20))
def test_a_name_that_there_is_is_what_was_meant(name, others):
    assert did_you_mean(name, [name, *others]).startswith("did you mean ")
    assert name in did_you_mean(name, [name, *others])


def test_one_name_and_many_are_told_in_good_english():
    assert did_you_mean("x", ["bow", "bow"]) == "there is bow"
    assert did_you_mean("x", ["b", "a"]) == "there are a, b"
    assert did_you_mean("xyz", [f"{n:02d}" for n in range(20)]).endswith("07, …")


@given(NAMES, st.lists(NAMES, max_size=20))
def test_a_name_that_is_known_is_nearest_to_itself(name, others):
    assert near(name, [name, *others], most=1) == [name]


@given(st.text("ab", min_size=1, max_size=2), st.sets(st.from_regex(r"[ab]{1,2}(-[2-4])?", fullmatch=True)))
def test_a_free_name_is_the_one_that_is_wanted_or_has_the_first_number_that_is_free(wanted, taken):
    found = first_free(wanted, taken.__contains__, "-")
    assert found not in taken
    before = [] if found == wanted else [wanted, *(f"{wanted}-{n}" for n in range(2, int(found.rpartition("-")[2])))]
    assert taken.issuperset(before)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("GANGNAM", "gangnam"),
        (" Walk fwd (4) ", "walk_fwd_4"),
        ("1st", "motion_1st"),
        ("", "motion"),
        ("日本", "motion"),
        ("x" * 90, "x" * 40),
        ("été", "ete"),
        ("Straße_2", "strasse_2"),
        ("Đi tới", "i_toi"),
    ],
)
def test_a_name_for_a_row_is_made_of_any_text(text, name):
    assert name_from(text, "motion") == name


@given(st.text())
def test_a_name_for_a_row_is_one_that_a_row_may_have_and_becomes_itself(text):
    name = name_from(text, "motion")
    assert re.fullmatch(NAME_PATTERN, name)
    assert len(name) <= LONGEST
    assert name_from(name, "motion") == name
