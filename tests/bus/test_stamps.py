"""Stamps and seals: what was made is read, what was not made is none, and only who has the key can seal."""

import json
import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from lbr.bus import stamp

KEY = bytes(range(16))
OTHER = bytes(range(1, 17))
names = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cs", "Cc", "Cf", "Zl", "Zp", "Zs", "Co", "Cn")), max_size=60
)
numbers = st.integers(0, 2**63 - 1)
payloads = st.binary(max_size=200)


@given(names, numbers, payloads, st.floats(0, 1e6), names)
def test_what_was_made_is_read_back_and_is_genuine_with_its_key_alone(source, seq, payload, waited_s, token):
    made = stamp.make(source, seq, payload, KEY, token=token, waited_s=waited_s)
    found = stamp.read(made)
    assert found is not None
    assert (found.source, found.seq, found.token) == (source, seq, token)
    assert found.waited_s == pytest.approx(waited_s)
    assert stamp.genuine(found, payload, KEY)
    assert not stamp.genuine(found, payload, OTHER)
    assert not stamp.genuine(found, payload + b" ", KEY)


@pytest.mark.parametrize("waited_s", [-1.0, -math.inf, math.nan])
def test_who_says_that_it_waited_less_than_no_time_has_not_waited(waited_s):
    found = stamp.read(stamp.make("a", 1, waited_s=waited_s))
    assert found is not None
    assert found.waited_s == 0.0


@given(payloads, numbers, st.integers(1, 2**40))
def test_a_seal_holds_the_number_and_the_time_together_with_the_payload(payload, seq, later):
    found = stamp.read(stamp.make("drive", seq, payload, KEY))
    assert found is not None
    for change in ({"seq": found.seq + later}, {"mono_ns": found.mono_ns + later}, {"boot": found.boot + "x"}):
        forged = stamp.read(json.dumps({**json.loads(stamp.make("drive", seq, payload, KEY)), **change}).encode())
        assert forged is None or not stamp.genuine(forged, payload, KEY)


@given(st.one_of(payloads, names.map(str.encode)))
def test_bytes_that_are_no_stamp_are_none_and_never_an_error(data):
    assume(not data.startswith(b'{"source"'))
    assert stamp.read(data) is None


@pytest.mark.parametrize(
    "change",
    [
        {"seq": -1}, {"seq": 1.5}, {"seq": 10**40}, {"mono_ns": "1"}, {"source": None}, {"wall_ns": -5}, {"boot": 3},
        {"waited_s": -0.1}, {"waited_s": None}, {"token": []},
    ],
)  # fmt: skip
def test_a_stamp_with_a_wrong_field_is_none(change):
    good = json.loads(stamp.make("drive", 3))
    assert stamp.read(json.dumps(good).encode()) is not None
    assert stamp.read(json.dumps({**good, **change}).encode()) is None


def test_a_stamp_of_a_later_lbr_with_more_fields_is_read():
    made = {**json.loads(stamp.make("drive", 3)), "signature": "new", "nested": {"a": [1]}}
    found = stamp.read(json.dumps(made).encode())
    assert found is not None
    assert found.source == "drive"


def test_what_is_larger_than_any_stamp_is_not_even_read():
    made = json.loads(stamp.make("drive", 3))
    assert stamp.read(json.dumps({**made, "more": "x" * stamp.MAX_STAMP_BYTES}).encode()) is None
    assert stamp.read(b"[" * stamp.MAX_STAMP_BYTES) is None


@pytest.mark.parametrize("attachment", [None, b""])
def test_nothing_is_no_stamp(attachment):
    assert stamp.read(attachment) is None
    assert not stamp.genuine(None, b"", KEY)


def test_without_a_key_nothing_is_genuine_since_anybody_could_have_made_it():
    """The hash of no key is one that everybody can compute."""
    unsealed = stamp.read(stamp.make("a", 1, b"payload"))
    assert unsealed is not None
    assert not stamp.genuine(unsealed, b"payload", b"")
    by_hand = stamp._seal(b"", b"payload", unsealed.seq, unsealed.mono_ns, unsealed.boot).decode()
    forged = stamp.read(
        json.dumps({**json.loads(stamp.make("a", 1)), "seal": by_hand, "mono_ns": unsealed.mono_ns}).encode()
    )
    assert forged is not None
    assert not stamp.genuine(forged, b"payload", b"")


@pytest.mark.parametrize("seal", ["", "0" * 32, "ä" * 32, "\x00", "🤖"])
def test_a_seal_of_any_characters_is_compared_and_fits_not(seal):
    found = stamp.read(json.dumps({**json.loads(stamp.make("a", 1, b"x", KEY)), "seal": seal}).encode())
    assert found is not None
    assert not stamp.genuine(found, b"x", KEY)


@given(payloads, names)
def test_what_is_passed_on_bears_its_door_and_no_seal_and_keeps_its_time(payload, token):
    made = stamp.make("phone", 7, payload, KEY, token="claimed")
    before, after = stamp.read(made), stamp.read(stamp.passed_on(made, "lan", token))
    assert before is not None
    assert after is not None
    assert (after.via, after.token, after.seal) == ("lan", token, "")
    assert (after.source, after.seq, after.mono_ns, after.boot) == ("phone", 7, before.mono_ns, before.boot)
    assert not stamp.genuine(after, payload, KEY)


@given(payloads)
def test_rubbish_that_is_passed_on_has_no_date_and_no_name(rubbish):
    assume(not rubbish.startswith(b'{"source"'))
    found = stamp.read(stamp.passed_on(rubbish, "lan"))
    assert found is not None
    assert (found.source, found.boot, found.token, found.via) == ("", "", "", "lan")
    assert stamp.sent_s(found, 12.5) == 12.5


@given(st.floats(0, 1e6), st.floats(0, 1e6))
def test_a_message_was_never_sent_after_it_arrived(sent_s, arrived):
    found = stamp.read(stamp.make("a", 1, sent_s=sent_s))
    assert stamp.sent_s(found, arrived) <= arrived
    assert stamp.sent_s(found, arrived) == pytest.approx(min(sent_s, arrived), abs=1e-6)


def test_times_of_another_boot_or_of_none_are_not_compared():
    made = json.loads(stamp.make("a", 1, sent_s=1.0))
    for boot in ("", "ffffffff", made["boot"] + "0"):
        assert stamp.sent_s(stamp.read(json.dumps({**made, "boot": boot}).encode()), 50.0) == 50.0
    assert stamp.sent_s(stamp.read(json.dumps(made).encode()), 50.0) == 1.0
    assert stamp.sent_s(None, 3.0) == 3.0
