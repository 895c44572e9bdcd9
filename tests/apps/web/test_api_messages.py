"""What a page says is a message or rubbish, whatever it is; and what is held is what can be passed on."""

import json

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.web.api.page_message import LARGEST, MOST_KEYS, PageMessage, Rubbish, parse

ANY_JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=12), inner, max_size=4),
    max_leaves=20,
)
FIELDS = st.sampled_from(["hear", "rate_hz", "hold", "keep", "release", "t", "to", "message", "n"])


def whatever(said: bytes) -> PageMessage | None:
    try:
        found = parse(said)
    except Rubbish as rubbish:
        told = str(rubbish)
        if not 0 < len(told) <= 200:
            raise
        return None
    msgspec.json.encode(found)
    return found


@given(st.binary(max_size=200))
def test_any_bytes_are_a_message_or_rubbish(said):
    whatever(said)


@given(st.dictionaries(FIELDS, ANY_JSON, max_size=5))
def test_any_json_in_the_fields_of_a_message_is_a_message_or_rubbish(said):
    whatever(json.dumps(said).encode())


@given(ANY_JSON, st.integers(0, 2**53))
def test_what_is_held_is_passed_on_as_it_is_without_what_is_the_servers(message, n):
    said = {"hold": {"to": "drive/command", "message": {"a": message, "lease": "x", "ttl_s": 1.0}, "n": n}}
    found = whatever(json.dumps(said).encode())
    if found is not None:
        assert isinstance(found.hold.message, dict)
        assert set(found.hold.message) == {"a"}
        assert found.hold.n == n


def hold(message: str) -> bytes:
    return b'{"hold": {"to": "drive/command", "message": %s, "n": 1}}' % message.encode()


@pytest.mark.parametrize(
    "said",
    [
        b"", b"{", b"null", b"[]", b'"x"', b"\xff\xfe", b"NaN", b'{"keep": NaN}', b'{"keep": 1e999}', b'{"keep": -1}',
        b'{"keep": 1.5}', b'{"keep": 99999999999999999999999999}', b'{"keep": "1"}', b'{"release": 1}', b'{"rate_hz": 0}',
        b'{"rate_hz": 1e9}', b'{"rate_hz": Infinity}', b'{"hear": "drive/state"}', b'{"hear": [1]}', b'{"t": "now"}',
        hold('{"power": NaN}'), hold('{"power": 1e999}'), hold("[]"), hold("null"), hold("1" * 5000),
        hold('{"power": %s}' % ("9" * 5000)),
        b'{"hold": {"to": "drive", "n": 1}}', b'{"hold": {"to": "@estop/x", "n": 1}}', b'{"hold": {"to": "drive/command"}}',
        b'{"hold": {"to": "drive/command", "message": {}, "n": -1}}', b'{"hold": {"to": "a/b/c", "n": 1}}',
        b'{"hold": {"to": "drive/**", "n": 1}}', b'{"hold": {"to": "../command", "n": 1}}',
        b"[" * 100_000, b'{"hold":' * 5000, b" " * (LARGEST + 1), json.dumps({"hear": ["a"] * (MOST_KEYS + 1)}).encode(),
        json.dumps({"hear": ["a" * 200]}).encode(),
    ],
)  # fmt: skip
def test_rubbish_is_told_from_a_message(said):
    assert whatever(said) is None


def test_deep_nesting_is_rubbish_or_can_be_passed_on():
    for depth in (10, 500, 990, 1000, 5000, 30_000):
        whatever(hold("[" * depth + "]" * depth))
        whatever(hold('{"a":' * depth + "1" + "}" * depth))


@pytest.mark.parametrize(
    "said",
    [
        b"{}", b'{"tomorrow": {"x": 1}}', b'{"hear": []}', b'{"hear": ["drive/state", "@event"], "rate_hz": 25}',
        hold('{"power": 0.5, "angle_deg": -0.0}'), b'{"keep": 3, "t": 17}', b'{"release": true}', b'{"hold": {"to": "a/b", "n": 0}}',
    ],
)  # fmt: skip
def test_what_a_page_says_is_understood_also_one_of_tomorrow(said):
    assert whatever(said) is not None
