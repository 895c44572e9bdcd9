"""Numbers as JavaScript has them: the cases that its specification names, and any others."""

from math import inf, isnan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.robots.uxa90.rest.number import begins_as_integer, clamped, nearest, number, plain, written


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("", 0), ("  ", 0), ("23", 23), ("23.0", 23), (" 23\n", 23), ("\u00a07\ufeff", 7), ("+5", 5), ("-5", -5),
        ("0x17", 23), ("0X1f", 31), ("0b101", 5), ("0o17", 15), ("010", 10), ("1e1", 10), ("1E+2", 100),
        (".5", 0.5), ("5.", 5), ("Infinity", inf), ("-Infinity", -inf), ("1e999", inf), ("-0", 0), ("0x" + "f" * 300, inf),
    ],
)  # fmt: skip
def test_what_is_a_number(text, value):
    assert number(text) == value


@pytest.mark.parametrize(
    "text",
    ["abc", "1,5", "1 2", "12px", "--1", "+-1", "1e", "e1", ".", "0x", "-0x10", "+0b1", "0b2", "infinity", "inf", "nan",
     "NaN", "1_000", "\u0665", "0x1.8", "null", "1" * 500],
)  # fmt: skip
def test_what_is_none(text):
    assert isnan(number(text))


@given(st.text(max_size=30))
def test_any_text_is_a_number_or_none(text):
    assert isinstance(number(text), float)
    assert isinstance(begins_as_integer(text), bool)


@given(st.floats(allow_nan=False))
def test_what_is_written_is_read_again(value):
    assert number(written(value)) == value


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (23.0, "23"), (-0.0, "0"), (0.5, "0.5"), (1e21, "1e+21"), (1e20, "100000000000000000000"), (1.5e-7, "1.5e-7"),
        (0.000001, "0.000001"), (123.456, "123.456"), (1e-7, "1e-7"), (1.25e300, "1.25e+300"), (float("nan"), "NaN"),
        (inf, "Infinity"), (-inf, "-Infinity"), (-1.5, "-1.5"),
    ],
)  # fmt: skip
def test_numbers_are_written_as_javascript_writes_them(value, text):
    assert written(value) == text


@pytest.mark.parametrize(
    ("text", "begins"),
    [("7", True), ("7up", True), (" 7", True), ("-1", True), ("0x1", True), ("0x", True), ("up7", False), ("", False),
     ("-", False), ("Infinity", False), (".5", False)],
)  # fmt: skip
def test_what_begins_as_an_integer(text, begins):
    assert begins_as_integer(text) is begins


@given(st.floats(-1e6, 1e6))
def test_the_nearest_count_is_near(value):
    assert abs(nearest(value) - value) <= 0.5


def test_whole_numbers_are_written_without_a_point():
    assert (repr(plain(100.0)), repr(plain(100.5)), repr(plain(-0.0))) == ("100", "100.5", "0")
    assert clamped(inf, 1, 254) == 254
