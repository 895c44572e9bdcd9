"""Wrong tokens are counted, told and slowed down by the host that shows them; who says a line is known by its token."""

import json
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.lan.attempts import FIRST_WAIT_S, FREE_TRIES, LONGEST_WAIT_S, MOST_PENDING, WINDOW_S, Attempts, host_of
from lbr.apps.lan.passage import Passage, Standstill
from lbr.bus import keys, session, stamp, wire
from lbr.bus.access import Credentials
from lbr.errors import BusError
from tests.support.door import Door
from tests.support.robot import lbr
from tests.support.waiting import HANG_S, until

WRONG = (
    "DEBUG zenoh_transport::unicast::establishment::accept: UsrPwd extension - Recv OpenSyn. Invalid password. at x.rs"
)
NOBODY = WRONG.replace("password", "user")


def let_in(address: str) -> str:
    return (
        f"New transport link accepted from ab to cd: Link {{ src: tls/1.2.3.4:7447, dst: tls/{address}, mtu: 65535 }}"
    )


def tries(attempts: Attempts, host: str, count: int, now: float = 0.0) -> list[str]:
    told = []
    for number in range(count):
        assert attempts.knock(f"{host}:{number + 1}", now)
        refusal = attempts.read(WRONG, now)
        told += [refusal.text] if refusal else []
    return told


def test_a_wrong_token_is_told_with_its_host_and_what_was_wrong():
    attempts = Attempts()
    attempts.knock("10.0.0.7:4711", 0.0)
    refusal = attempts.read(NOBODY, 0.1)
    assert (refusal.host, refusal.tries, refusal.wait_s, refusal.unknown_name) == ("10.0.0.7", 1, 0.0, True)
    assert refusal.text == "10.0.0.7 showed a token with an unknown name"
    assert attempts.refused == 1


def test_after_some_tries_a_host_waits_longer_each_time_and_others_do_not():
    attempts = Attempts()
    tries(attempts, "10.0.0.7", FREE_TRIES)
    assert attempts.knock("10.0.0.7:100", 1.0)
    now, waits = 1.0, []
    for _ in range(8):
        attempts.read(WRONG, now)
        wait_s = next(s / 10 for s in range(1000) if attempts._hosts["10.0.0.7"].until_s <= now + s / 10)
        waits.append(wait_s)
        assert not attempts.knock("10.0.0.7:101", now + wait_s - 0.2)
        assert attempts.knock("10.0.0.8:101", now)
        attempts.read(let_in("10.0.0.8:101"), now)
        now += wait_s + 0.1
        assert attempts.knock("10.0.0.7:102", now)
    assert waits[:5] == [1.0, 2.0, 4.0, 8.0, 16.0]
    assert max(waits) == LONGEST_WAIT_S


def test_who_is_let_in_is_blamed_for_nothing():
    attempts = Attempts()
    attempts.knock("10.0.0.8:1", 0.0)
    attempts.knock("10.0.0.7:1", 0.0)
    attempts.read(let_in("10.0.0.8:1"), 0.1)
    assert attempts.read(WRONG, 0.2).host == "10.0.0.7"


def test_tries_of_long_ago_are_forgiven():
    attempts = Attempts()
    tries(attempts, "10.0.0.7", FREE_TRIES)
    assert attempts.knock("10.0.0.7:9", WINDOW_S + 1.0)
    assert attempts.read(WRONG, WINDOW_S + 1.0).wait_s == 0.0


@pytest.mark.parametrize(
    ("address", "host"),
    [
        ("10.0.0.7:4711", "10.0.0.7"),
        ("[fe80::1]:4711", "fe80::1"),
        ("[::ffff:10.0.0.7]:4711", "10.0.0.7"),
    ],
)
def test_a_host_is_what_stands_before_the_port(address, host):
    assert host_of(address) == host


@given(
    st.lists(
        st.one_of(
            st.tuples(st.just("knock"), st.integers(0, 600), st.floats(0.0, 5.0)),
            st.tuples(st.just("line"), st.sampled_from([WRONG, NOBODY, let_in("10.0.0.1:1"), ""]), st.floats(0.0, 5.0)),
            st.tuples(st.just("line"), st.text(max_size=200), st.floats(0.0, 5.0)),
        ),
        max_size=200,
    )
)
def test_whatever_comes_it_keeps_little_and_never_lets_a_host_wait_longer_than_promised(history):
    attempts, now = Attempts(), 0.0
    for what, value, later_s in history:
        now += later_s
        if what == "knock":
            attempts.knock(f"10.0.0.{value % 256}:{value}", now)
        else:
            attempts.read(value, now)
        assert len(attempts._pending) <= MOST_PENDING
        assert all(host.until_s <= now + LONGEST_WAIT_S for host in attempts._hosts.values())


def test_silence_is_a_fault_only_when_questions_stay_without_answer():
    passage = Passage()
    for _ in range(10):
        passage.count_statuses(outside=True, inside=False)
    assert (passage.doubtful, passage.broken) == (True, False)
    passage.asked(answered=False)
    passage.asked(answered=True)
    assert not passage.doubtful
    for _ in range(10):
        passage.count_statuses(outside=True, inside=False)
        if passage.doubtful:
            passage.asked(answered=False)
    assert passage.broken
    passage.count_statuses(outside=True, inside=True)
    assert not passage.broken


def test_nothing_is_concluded_where_nothing_was_heard_outside_either():
    passage = Passage()
    for _ in range(100):
        passage.count_statuses(outside=False, inside=False)
    assert not passage.doubtful


def test_a_thread_stands_still_by_rounds_and_not_by_seconds():
    still = Standstill()
    assert [still.see("relay", turns) for turns in (1, 2, 2, 2, 3, 3)] == [0, 0, 1, 2, 0, 1]


@pytest.fixture
def odd_shell(monkeypatch: pytest.MonkeyPatch) -> None:
    """One with a wish for the library's log that it cannot read: a door that went by them would hear of no wrong token."""
    monkeypatch.setenv("RUST_LOG", "lbr=verbose,x=[")


@pytest.mark.usefixtures("odd_shell")
def test_guessing_is_counted_told_and_slowed_down_and_the_right_token_gets_in_afterwards(own_door: Door):
    wrong = Credentials(user="phone", password="x" * 43)

    def guess() -> float:
        began = time.monotonic()
        with pytest.raises(BusError):
            session.open_client([own_door.endpoint], wrong, certificate=own_door.certificate, timeout_s=0.0)
        return time.monotonic() - began

    for _ in range(FREE_TRIES):
        guess()
    assert own_door.refuses("phone") == ""
    guess()
    assert guess() > 0.9 * FIRST_WAIT_S, "its connection was held"
    until(lambda: "wrong tokens: 7" in own_door.robot.capability("lan")["reason"], what="it is counted")
    told = [event["text"] for event in own_door.robot.events() if event["kind"] == "login_refused"]
    assert told[0] == "127.0.0.1 showed a token with a wrong secret"
    assert told[-1].endswith("its next connections wait 1 s")
    until(lambda: own_door.refuses("phone") == "", what="the right token gets in")


def test_the_audit_trail_names_the_token_of_who_said_a_line(own_door: Door):
    own_door.drive("phone", "/r/0.1/90", hold_s=0.1)
    with own_door.client("phone") as bus:
        sealed = stamp.make("a program", 0, b"/s/hello", b"not the secret", token="boss")
        query = bus.get(keys.console("lbr", "operate"), payload=b"/r/0/0", attachment=sealed, timeout=HANG_S)
        assert json.loads(next(iter(query)).ok.payload.to_bytes())["code"] == 0
        wire.ask(bus, "lbr/drive/stop", {}, source="test")

    def lines() -> list[str]:
        said = lbr(own_door.robot.home, "db", "audit").stdout.splitlines()
        return [line for line in said if " line console: " in line]

    until(lambda: len(lines()) >= 2, what="both lines are in the trail")
    mine, claimed = lines()[:2]
    assert "on another machine (by token 'phone')" in mine
    assert mine.endswith("/r/0.1/90")
    assert "a program on another machine (token not told)" in claimed
    assert "boss" not in claimed
