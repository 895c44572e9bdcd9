"""Settings are told all their faults at once, and have one exactly if msgspec finds one."""

from typing import Annotated, Literal

import msgspec
from hypothesis import given
from hypothesis import strategies as st
from msgspec import Meta, Struct

from lbr.capability.settings import faults

Small = Annotated[float, Meta(gt=0.0, le=5.0)]


class Inner(Struct, frozen=True, forbid_unknown_fields=True):
    at: Small = 1.0
    words: tuple[Annotated[str, Meta(min_length=1)], ...] = ()


class Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, rename={"kind": "type"}):
    near_m: Small
    device: str
    kind: str = ""
    inner: Inner = Inner()

    def __post_init__(self) -> None:
        if self.device == "bad":
            raise KeyError(self.device)
        if self.device == "worse":
            raise ValueError("worse")


def test_every_field_says_its_own_with_its_path(wording):
    found = faults(Settings, {"near_m": 9, "kind": "a", "inner": {"at": "x", "words": ["a", ""], "other": 1}})
    wording(*found)


def test_a_misspelt_field_is_told_which_one_it_may_have_been(wording):
    wording(faults(Settings, {"near_m": 1, "devise": "a"})[0])


def test_what_a_struct_says_of_itself_is_told_whatever_it_raises():
    assert faults(Settings, {"near_m": 1, "device": "worse"}) == ("worse",)
    assert faults(Settings, {"near_m": 1, "device": "bad"}) == ("KeyError: 'bad'",)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-3, 9) | st.sampled_from(["", "a", "worse"]),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["near_m", "device", "type", "inner", "at", "words", "x"]), inner, max_size=5)
    ),
    max_leaves=12,
)


@given(JSON)
def test_there_are_faults_exactly_if_msgspec_has_one(value):
    try:
        msgspec.json.decode(msgspec.json.encode(value), type=Settings)
        good = True
    except msgspec.ValidationError:
        good = False
    found = faults(Settings, value)
    assert (found == ()) == good
    assert len(set(found)) == len(found)


class Pad(Struct, frozen=True, forbid_unknown_fields=True):
    stop: Literal["a", "thumb", "start", ""] = ""
    lines: dict[Literal["a", "thumb", "start"], str] = {}


def test_a_value_that_is_no_choice_is_told_which_there_are():
    assert faults(Pad, {"stop": "thum", "lines": {"z": "s"}}) == (
        "Invalid enum value 'thum', did you mean thumb? - at `$.stop`",
        "Invalid enum value 'z', there are a, start, thumb - at `key` in `$` - at `$.lines`",
    )


@given(value=st.text())
def test_a_text_that_is_no_choice_is_named_whatever_it_is(value):
    found = faults(Pad, {"stop": value})
    if value in {"a", "thumb", "start", ""}:
        assert not found
    else:
        assert "`$.stop`" in found[0]
        assert "did you mean" in found[0] or "there are a, start, thumb" in found[0]
