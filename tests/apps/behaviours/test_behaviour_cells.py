"""Conditions of state tables: what fits, by how much something else misses, and bad cells with what to write instead."""

from contextlib import suppress
from math import inf, isfinite, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.behaviours import keys
from lbr.apps.behaviours.cells import CellError, Fits, parse
from lbr.messages.behaviour import BehaviourState

FITS = [
    ("40", [40.0], [39.9, 40.1, "forty"]),
    ("85:100", [85.0, 100.0], [84.9, 100.1]),
    ("-5 : -2", [-5.0, -2.0], [-1.9, 0.0]),
    ("40 ± 1", [39.0, 41.0], [38.9, 41.1]),
    ("40+-1", [39.0, 41.0], [38.9]),
    ("40 +/- 1", [40.5], [42.0]),
    ("< 39", [38.9], [39.0, inf]),
    ("<39", [38.9], [39.0]),
    (">=20", [20.0, 30.0], [19.9]),
    (">= 20", [20.0], [19.9]),
    ("≥ 20", [20.0], [19.9]),
    ("<> 3", [2.0, 4.0], [3.0]),
    ("= 3", [3.0], [3.1]),
    ("> 10 and < 20", [15.0], [10.0, 20.0]),
    ("< 10 or > 20", [9.0, 21.0], [15.0]),
    ("(< 10 or > 20) and < 30", [25.0, 0.0], [30.0, 15.0]),
    ("low", ["low"], ["ok", 1.0]),
    ("low or critical", ["low", "critical"], ["ok"]),
    ("!= low", ["ok", 1.0], ["low"]),
    ('"way or wall"', ["way or wall"], ["way", "wall"]),
    ("way blocked", ["way blocked"], ["way"]),
    ("true", [1.0], [0.0]),
    ("no", [0.0], [1.0]),
    ("1", [1.0], [0.0]),
]


@pytest.mark.parametrize(("text", "fitting", "others"), FITS)
def test_a_condition_holds_for_what_it_says_and_nothing_else(text, fitting, others):
    fits = parse(text).fits
    assert all(fits.off(value) == 0.0 for value in fitting)
    assert all(fits.off(value) > 0.0 for value in others)


@pytest.mark.parametrize(("text", "fitting", "others"), FITS)
def test_what_is_missing_or_no_number_never_holds(text, fitting, others):
    assert parse(text).fits.off(None) == inf
    assert parse(text).fits.off(nan) == inf


def test_missing_is_a_condition_of_its_own():
    assert parse("missing").fits.off(None) == 0.0
    assert parse("> 60 or missing").fits.off(None) == 0.0
    assert parse("known").fits.off(None) == inf
    assert parse("known").fits.off("x") == parse("known").fits.off(-3.0) == 0.0


@pytest.mark.parametrize(
    ("text", "value", "off"),
    [("< 39", 41.5, 2.5), ("85:100", 80.0, 5.0), ("40 ± 1", 44.0, 3.0), ("10 or 20", 13.0, 3.0)],
)
def test_a_miss_is_told_by_how_much(text, value, off):
    assert parse(text).fits.off(value) == pytest.approx(off)


@pytest.mark.parametrize(
    ("text", "fitting", "others"),
    [
        ("330:30", [330.0, 0.0, 359.9, 30.0], [31.0, 180.0, 329.0]),
        ("5 ± 10", [355.0, 0.0, 360.0, 15.0], [354.0, 16.0]),
        ("-10:10", [355.0, 5.0], [20.0]),
        ("0", [0.0, 360.0], [1.0]),
        ("350:360", [360.0, 0.0], [349.0, 1.0]),
        ("30:-30", [30.0, 180.0, 330.0], [29.0, 0.0, 360.0, 331.0]),
        ("-10:-350", [350.0, 0.0, 10.0], [11.0, 180.0, 349.0]),
        ("370:20", [10.0, 20.0], [0.0, 5.0, 21.0, 360.0]),
    ],
)
def test_a_heading_goes_across_north(text, fitting, others):
    fits = parse(text, turning=True).fits
    assert all(fits.off(value, turning=True) == 0.0 for value in fitting)
    assert all(fits.off(value, turning=True) > 0.0 for value in others)


def test_a_heading_misses_by_the_shorter_way():
    assert parse("350:355", turning=True).fits.off(5.0, turning=True) == pytest.approx(10.0)


def test_a_cell_says_how_long_how_new_and_when():
    cell = parse("becomes < 50")
    assert cell.becomes
    assert parse("< 50 for 2 s").for_s == 2.0
    assert parse("low or critical for 10 s").for_s == 10.0
    assert parse(">= 12.8 newer than 30 s").newest_s == 30.0
    assert parse("< 5 for 1 newer 2").newest_s == 2.0


@pytest.mark.parametrize(
    "text",
    [
        "",
        "<",
        "40 -1",
        "100:85",
        "40 ± -1",
        "(40",
        "< low",
        "5 for",
        "1e999",
        "5 and",
        "(" * 50 + "1" + ")" * 50,
        "x" * 301,
    ],
)
def test_a_bad_cell_is_refused_with_what_to_write(text, wording):
    with wording.of(CellError):
        parse(text)


@given(
    st.text(max_size=60)
    | st.lists(
        st.sampled_from(
            ["<", ">=", "40", "±", ":", "or", "and", "(", ")", "for", "x", "2 s", "becomes", "missing", "=="]
        ),
        max_size=12,
    ).map(" ".join),
    st.booleans(),
)
def test_no_text_is_more_than_a_bad_cell(text, turning):
    with suppress(CellError):
        assert all(low <= high for low, high in parse(text, turning=turning).fits.numbers)


numbers = st.floats(-1e6, 1e6)
fits_of = st.lists(st.tuples(numbers, numbers).map(lambda pair: (min(pair), max(pair))), max_size=4).map(
    lambda pairs: Fits() if not pairs else _together(pairs)
)


def _together(pairs):
    found = Fits()
    for pair in pairs:
        found = found.either(Fits((pair,)))
    return found


@given(fits_of, fits_of, numbers)
def test_either_and_both_say_the_same_as_the_values(one, other, value):
    in_one, in_other = one.off(value) == 0.0, other.off(value) == 0.0
    assert (one.either(other).off(value) == 0.0) == (in_one or in_other)
    assert (one.both(other).off(value) == 0.0) == (in_one and in_other)


@given(fits_of, numbers)
def test_a_value_that_misses_fits_once_it_is_moved_so_far(fits, value):
    off = fits.off(value)
    if isfinite(off) and off > 0.0:
        assert min(fits.off(value + off), fits.off(value - off)) <= 1e-6


def test_a_column_is_a_bare_name_or_a_whole_path():
    there = frozenset({"battery", "ranges", "drive", "motors", "attitude"})
    assert keys.resolve("charge", there).name == "battery.charge"
    assert keys.resolve("battery.charge").name == "battery.charge"
    assert keys.resolve("ranges.others_m.lidar").path == ("others_m", "lidar")
    assert keys.resolve("Forward").times == 100.0
    assert keys.resolve("heading").turning


@pytest.mark.parametrize(
    "column",
    [
        "left",
        "chrge",
        "nothing.at.all",
        "$",
    ],
)
def test_a_column_that_is_ambiguous_or_unknown_is_refused(column, wording):
    with wording.of(CellError):
        keys.resolve(column)


def test_a_column_of_a_stream_that_the_robot_lacks_is_refused(wording):
    with wording.of(CellError):
        keys.resolve("Dock Left", frozenset({"ranges"}))


@given(st.text(max_size=40))
def test_no_column_is_more_than_refused(column):
    with suppress(CellError):
        assert keys.resolve(column).column == column


def test_every_name_of_the_telemetry_is_found_and_reads_nothing_from_another_message():
    for name in keys.all_names():
        key = keys.resolve(name.replace("*", "some"))
        assert key.read(BehaviourState(phase="resting")) is None or key.path[-1] in {"reason", "code", "phase"}
