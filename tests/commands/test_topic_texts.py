"""What `lbr topic` prints of what comes on a bus: lines that a terminal may get, whatever the bytes are."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.bus import wire
from lbr.bus.wire import RawMessage
from lbr.commands import topic
from lbr.console import topics
from lbr.console.rates import Rate
from lbr.errors import InputError

KEY = "lbr/drive/command"
OURS = "lbr topic 7"
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=6), inner, max_size=3),
    max_leaves=12,
)


def printed(payload: bytes, capsys, *, named: bool = False, as_json: bool = False) -> str:
    topic.print_message(RawMessage("lbr/a/b", payload, b"", 0.0), as_json=as_json, raw=False, named=named)
    return capsys.readouterr().out


@pytest.mark.parametrize(
    "name", ["", "#", "a?", "$x", "drive//state", "drive/*x", "***/state", "a b", "a\nb", "\ud800"]
)
def test_what_is_no_topic_is_told_before_the_bus_is_asked(name, wording):
    with wording.of(InputError):
        topics.key_of("lbr", name)


@given(st.text() | st.text(alphabet="*/@a$"))
def test_whatever_is_typed_is_a_key_of_the_bus_or_no_topic(name):
    try:
        key = topics.key_of("lbr", name)
    except InputError:
        return
    assert wire.canonical(key) == key


@given(st.binary(max_size=60) | JSON.map(lambda value: json.dumps(value).encode()))
def test_whatever_comes_is_lines_without_anything_that_moves_a_cursor(payload):
    lines = list(topic.lines_of(topic.value_of(payload)))
    assert all(line.isprintable() for line in lines)


@given(st.dictionaries(st.text("abc", min_size=1, max_size=4), st.integers() | st.text(max_size=6), max_size=5))
def test_every_field_of_a_flat_message_has_its_line(message):
    lines = list(topic.lines_of(topic.value_of(json.dumps(message).encode())))
    assert len(lines) == len(message)
    assert all(line.startswith(f"{name}: ") for line, name in zip(lines, message, strict=True))


def test_what_is_within_is_indented_below_its_name(capsys):
    assert printed(b'{"a": {"b": {"c": 1.23456789}, "d": []}, "e": {}, "f": "x\\u001by"}', capsys).splitlines() == [
        "a:", "  b:", "    c: 1.23457", "  d: []", "e: {}", "f: x y", "---",
    ]  # fmt: skip


@pytest.mark.parametrize("opens", [b"[", b'{"a":'])
@pytest.mark.parametrize("depth", [50, 300, 700, 2000, 100_000])
def test_what_is_nested_without_end_is_told_and_no_error(opens, depth, capsys):
    closes = b"]" if opens == b"[" else b"}"
    for payload in (opens * depth, opens * depth + b"1" + closes * depth):
        assert printed(payload, capsys).endswith("---\n")
        assert len(printed(payload, capsys, as_json=True).splitlines()) == 1


@pytest.mark.parametrize("payload", [b"", b"{", b"\xff\xfe", b'"\xff"', b'{"a": 1}x'])
def test_bytes_that_are_no_json_are_counted(payload):
    assert topic.value_of(payload) == f"{len(payload)} bytes that are not JSON"


def test_with_more_than_one_topic_each_message_says_whose_it_is(capsys):
    assert printed(b"1", capsys, named=True) == "# lbr/a/b\n1\n---\n"
    assert json.loads(printed(b"1", capsys, named=True, as_json=True)) == {"key": "lbr/a/b", "message": 1}
    assert json.loads(printed(b"1", capsys, as_json=True)) == 1


def refusal(**event: object) -> str:
    payload = json.dumps({"kind": "refused", "subject": "lan", "text": "no", **event}).encode()
    return topic.refusal_in(RawMessage("lbr/@event", payload, b"", 0.0), KEY, OURS)


def test_a_refusal_counts_if_it_is_of_this_topic_of_its_owner_or_of_us():
    assert refusal(data={"key": KEY}) == "lan: no"
    assert refusal(about=OURS) == "lan: no"
    assert refusal(subject="drive") == "drive: no"
    assert refusal() == refusal(data={"key": "lbr/other"}) == refusal(about="another") == ""
    assert refusal(subject="drive", kind="lease") == ""


def test_a_refusal_that_a_stranger_made_up_moves_no_cursor_and_is_one_line():
    said = refusal(subject="drive", text="no\n\x1b[2Jrobot 'lbr' has shut down")
    assert said.isprintable()
    assert said.startswith("drive: no")


@given(st.binary(max_size=80) | JSON.map(lambda value: json.dumps({"kind": "refused", "data": value}).encode()))
def test_no_event_is_too_odd_to_be_looked_at(payload):
    assert isinstance(topic.refusal_in(RawMessage("lbr/@event", payload, b"", 0.0), KEY, OURS), str)


def rate(**known: object) -> Rate:
    nothing = dict.fromkeys(Rate.__struct_fields__)
    return Rate(**{**nothing, "key": "lbr/a/b", "source": "imu", "received_hz": 9.96, "bytes_per_s": 1234.0, **known})


def test_a_stream_is_told_with_what_is_known_of_it_alone():
    assert topic.rate_text(rate()) == "lbr/a/b from imu: published ? Hz, received 10.0 Hz, 1.2 kB/s"
    told = topic.rate_text(
        rate(
            publisher_hz=50.0, lost=3, lost_percent=1.25, period_p50_ms=20.0, period_p99_ms=31.5, age_p50_ms=0.5,
            age_p99_ms=2.0,
        )
    )  # fmt: skip
    assert told == (
        "lbr/a/b from imu: published 50.0 Hz, received 10.0 Hz, lost 3 (1.2 %), period p50 20.0 p99 31.5 ms, "
        "age p50 0.50 p99 2.00 ms, 1.2 kB/s"
    )


def test_who_publishes_cannot_forge_a_line_by_its_name():
    assert topic.rate_text(rate(source="imu\n\x1b[1mdrive")).isprintable()
