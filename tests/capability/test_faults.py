"""Whatever a kind declares, what is wrong with it is told in sentences, and nothing that it says is run into."""

import re
from dataclasses import fields, replace

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from msgspec import Struct

from lbr.capability.base import Capability
from lbr.capability.faults import PORTS, faults
from lbr.capability.kind import Command, Kind, KindError, OnDevice, Rights, Rows
from lbr.capability.word import Word
from lbr.messages.rows import Row
from tests.support.packages import imported_from


class Settings(Struct, frozen=True, forbid_unknown_fields=True):
    device: str = ""


class Go(Struct, frozen=True):
    far_m: float = 0.0


class Kept(Row, frozen=True, kw_only=True):
    TABLE = "kept"
    KEY = ("name",)
    name: str


class Keyed(Row, frozen=True, kw_only=True):
    TABLE = "keyed"
    KEY = 3
    name: str


class Unreadable:
    def __repr__(self) -> str:
        raise RuntimeError("no words")


GOOD = Kind(
    name="own",
    summary="a thing",
    family="app",
    entry=Capability,
    settings=Settings,
    commands={
        "go": Command(Go, leased=True, role="admin"),
    },
    replies={"go": Go},
    words=(Word("go", "go", "Go"),),
    rows=(Rows(Kept, where={"name": "device"}, learnt=True),),
    device=OnDevice("claw"),
)
NAMES = [field.name for field in fields(Kind)]
ODD = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-1, 3),
    st.sampled_from(
        ["", "go", "a:B", "Big", "\x1b[2J", "x" * 900, Unreadable, Go, Go(), Kept, Keyed, Rows(Kept), Struct, Row]
    ),
)
PARTS = st.recursive(
    ODD,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.lists(inner, max_size=3).map(tuple),
        st.dictionaries(st.sampled_from(["go", "\x1b[2J", "g" * 900, 3, None]), inner, max_size=2),
        inner.map(lambda one: Rows(Kept, where=one)),
        inner.map(Rows),
        inner.map(Command),
        inner.map(OnDevice),
        inner.map(Rights),
        st.tuples(inner, inner, inner, inner, inner).map(lambda five: Word(*five)),
    ),
    max_leaves=6,
)


def test_a_kind_that_is_whole_has_no_fault():
    assert faults(GOOD) == ()


@example({"optional": [[]]})
@given(st.dictionaries(st.sampled_from(NAMES), PARTS, max_size=4))
def test_whatever_stands_in_a_field_the_faults_are_short_lines(said):
    for found in faults(replace(GOOD, **said)):
        assert found.isprintable()
        assert len(found) < 400


@pytest.mark.parametrize("field", [name for name in NAMES if name != "name"])
@pytest.mark.parametrize("value", [3, Unreadable()], ids=["number", "thing"])
def test_a_value_that_no_field_can_have_is_a_fault_that_names_the_field(field, value):
    assert any(f"'{field}'" in found for found in faults(replace(GOOD, **{field: value})))


@pytest.mark.parametrize(
    "said",
    [
        {"rows": (Keyed,)},
        {"rows": (Rows(Kept, where=["name"]),)},
        {"rights": Rights(edits=(Go,))},
        {"rights": Rights(lets_in=("enabled", "gate"))},
        {"rights": Rights(pairs=1, edits=["kept"])},
        {"device": OnDevice("claw", line="bent", emulated="dream")},
        {"needs": "numpy"},
        {"optional": ("eyes",)},
        {"optional": "ranges"},
        {"commands": 3, "replies": {}},
        {"commands": {"go": Command(Go, choices={"near": list})}, "words": ()},
        {"commands": {"go": Command(Go, choices={"far_m": 3})}, "words": ()},
    ],
)
def test_what_is_wrong_is_named_with_where_it_stands(said, wording):
    wording(*faults(replace(GOOD, **said)))


@pytest.mark.parametrize("field", [*PORTS, "wires"])
def test_a_name_that_moves_a_cursor_or_has_no_end_is_told_as_a_short_line(field):
    for name in ("\x1b[2J", "g" * 900):
        told = faults(replace(GOOD, **{field: {name: 3}}))
        assert told
        assert all(found.isprintable() and len(found) < 400 for found in told)


@given(st.text(max_size=60))
def test_an_entry_as_text_is_a_module_and_a_class(text):
    whole = re.fullmatch(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*", text) is not None
    assert (faults(replace(GOOD, entry=text)) == ()) == whole


@pytest.mark.parametrize(
    ("code", "entry", "why"),
    [
        ("", "theirs_of_no_module:Go", "ModuleNotFoundError: No module named 'theirs_of_no_module'"),
        ("", "crab_entry:Gone", "AttributeError: module 'crab_entry' has no attribute 'Gone'"),
        ("x = 1\ny = z", "crab_entry:Go", "NameError: name 'z' is not defined (crab_entry.py, line 2)"),
        ("x = (", "crab_entry:Go", "SyntaxError: '(' was never closed (crab_entry.py, line 1)"),
    ],
)
def test_an_entry_that_does_not_load_is_told_with_its_kind_and_the_line_that_is_wrong(tmp_path, code, entry, why):
    (tmp_path / "crab_entry.py").write_text(code)
    with imported_from(tmp_path), pytest.raises(KindError) as caught:
        replace(GOOD, entry=entry).load()
    assert str(caught.value) == f"kind '{GOOD.name}': its entry {entry} does not load: {why}"
