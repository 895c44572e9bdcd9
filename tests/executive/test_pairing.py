"""The life of a code, by a model: whatever is tried, and whenever, one device gets in by it, and guessers five tries."""

import json
import re
import time
from types import SimpleNamespace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from lbr.bus import stamp
from lbr.errors import InputError
from lbr.executive.service import pairing_service
from lbr.executive.service.pairing import GOOD_FOR_S, MOST_ADDRESSES, WRONG_TRIES, Pairing, drawn
from lbr.executive.service.pairing_service import DELAY_S, MOST_WAITING, NOT_GOOD, PairingService
from lbr.messages.pairing import PairReply

ADDRESSES = st.sampled_from(["192.168.1.7", "10.0.0.2", "fd00::2"])


class Life(RuleBasedStateMachine):
    """Every try, of any address, at any time, against what was promised of the code."""

    def __init__(self) -> None:
        super().__init__()
        self.now = 0.0
        self.drawn = 0
        self.pairing = Pairing(lambda: self.now, self.draw)
        self.good = ""
        self.ends = self.wrong = 0.0
        self.wrong_from: dict[str, int] = {}

    def draw(self) -> str:
        self.drawn += 1
        return f"{self.drawn * 7919 % 10**6:06d}"

    @rule(role=st.sampled_from(["view", "operate", "admin"]))
    def begin(self, role):
        code = self.pairing.begin(role, "console")
        assert code.role == role
        assert code.digits != self.good
        self.good, self.wrong, self.ends = code.digits, 0, self.now + GOOD_FOR_S

    @rule(s=st.floats(0.1, 90.0))
    def wait(self, s):
        self.now += s

    @rule()
    def cancel(self):
        assert self.pairing.cancel() is self.lives
        self.good = ""

    @rule(address=ADDRESSES, digits=st.integers(0, 999_999).map("{:06d}".format))
    def guess(self, address, digits):
        if digits != self.good:
            self.is_wrong(address, digits)

    @rule(address=ADDRESSES, near=st.integers(0, 5))
    @precondition(lambda self: self.good)
    def try_all_digits_but_one(self, address, near):
        digit = (int(self.good[near]) + 1) % 10
        self.is_wrong(address, f"{self.good[:near]}{digit}{self.good[near + 1 :]}")

    @rule(address=ADDRESSES)
    @precondition(lambda self: self.good)
    def show(self, address):
        if not self.lives:
            self.is_wrong(address, self.good)
            return
        tried = self.pairing.attempt(self.good, address)
        assert tried.code is not None
        assert tried.code.digits == self.good
        used, self.good = self.good, ""
        self.is_wrong(address, used)

    def is_wrong(self, address, digits):
        lived = self.lives
        self.wrong_from[address] = self.wrong_from.get(address, 0) + 1
        tried = self.pairing.attempt(digits, address)
        assert tried.code is None
        assert tried.from_there == self.wrong_from[address]
        self.wrong += lived
        assert tried.tries_left == (WRONG_TRIES - self.wrong if lived else None)
        if self.wrong >= WRONG_TRIES:
            self.good = ""

    @property
    def lives(self) -> bool:
        return bool(self.good) and self.now < self.ends

    @invariant()
    def bears_no_more_than_five_wrong_tries(self):
        assert self.wrong <= WRONG_TRIES


TestLife = Life.TestCase
TestLife.settings = settings(stateful_step_count=30)


def test_codes_are_six_digits_by_chance():
    many = {drawn() for _ in range(300)}
    assert len(many) > 290
    assert all(re.fullmatch("[0-9]{6}", one) for one in many)


def test_addresses_without_end_take_no_memory_without_end():
    pairing = Pairing(lambda: 0.0)
    for n in range(MOST_ADDRESSES + 20):
        pairing.attempt("000000", f"fd00::{n:x}")
    assert len(pairing._wrong_from) == MOST_ADDRESSES
    assert pairing.attempt("000000", f"fd00::{MOST_ADDRESSES + 19:x}").from_there == 2


# -- who shows them -----------------------------------------------------------------------------------------------------


class Asked:
    """A request on the bus, and its answer."""

    def __init__(self, payload: bytes | dict, source: str = "web") -> None:
        self.payload = payload if isinstance(payload, bytes) else json.dumps(payload).encode()
        self.attachment = stamp.make(source, 0)
        self.arrived = time.monotonic()
        self.answer: PairReply | None = None

    def reply(self, message: PairReply, source: str) -> None:
        assert self.answer is None
        assert source == "executive"
        self.answer = message


class Desk:
    """The service with fakes at its ends."""

    def __init__(self) -> None:
        self.came: list[Asked] = []
        self.events: list[tuple[str, str, str, str]] = []
        self.given: list[str] = []
        self.now = 0.0
        self.pairing = Pairing(lambda: self.now, lambda: "123456")
        self.service = PairingService(
            SimpleNamespace(take=self.take, close=lambda: None), self.pairing, self, happened=self.happened
        )

    def take(self):
        came, self.came = self.came, []
        return came

    def happened(self, *event):
        self.events.append(event)

    def pairs(self, name):
        return name == "web"

    def grant(self, name, code, asked, *, since_s):
        if asked.name == "broken":
            raise InputError("the disk is full")
        self.given.append(asked.name)
        return PairReply(accepted=True, token="t", role=code.role)

    def show(self, digits: str, address: str = "10.0.0.9", **more: str) -> Asked:
        asked = Asked({"digits": digits, "address": address, "name": "phone", **more})
        self.came.append(asked)
        self.service.step(self.now)
        return asked


@pytest.fixture
def desk() -> Desk:
    return Desk()


def test_the_right_digits_give_one_token_at_once_with_the_role_that_was_asked_for_at_the_console(desk):
    desk.pairing.begin("view", "console")
    first, second = desk.show("123456"), desk.show("123456")
    assert first.answer == PairReply(accepted=True, token="t", role="view")
    assert desk.given == ["phone"]
    assert second.answer is None
    assert desk.service.step(desk.now + DELAY_S) > 1e9
    assert second.answer.reason == NOT_GOOD


def test_wrong_digits_are_answered_late_and_alike_whether_there_is_a_code_or_not(desk):
    without = desk.show("000000")
    desk.pairing.begin("operate", "console")
    near, far = desk.show("123457"), desk.show("999999")
    assert desk.service.step(DELAY_S - 0.01) == pytest.approx(DELAY_S)
    assert not any(one.answer for one in (without, near, far))
    desk.service.step(DELAY_S)
    assert without.answer == near.answer == far.answer
    assert (near.answer.accepted, near.answer.code, near.answer.token) == (False, "token", "")


def test_a_guesser_over_many_connections_has_five_tries_in_all_and_each_is_told(desk, wording):
    desk.pairing.begin("operate", "console")
    asked = [Asked({"digits": f"{n:06d}", "address": f"10.0.0.{n}"}) for n in range(20)]
    desk.came = [*asked, Asked({"digits": "123456", "address": "10.0.0.99"})]
    last = desk.came[-1]
    desk.service.step(0.0)
    desk.service.step(DELAY_S)
    assert last.answer.reason == NOT_GOOD
    texts = [event[2] for event in desk.events]
    assert len([text for text in texts if "wrong code" in text]) == WRONG_TRIES
    wording(*(text for text in texts if "10.0.0.4" in text))
    assert len(texts) == WRONG_TRIES + 1, "tries without a code are told together"
    assert {event[0] for event in desk.events} == {"pair_refused"}
    assert not any("123456" in str(event) or "000004" in str(event) for event in desk.events)


def test_no_more_are_looked_at_than_may_wait(desk):
    desk.pairing.begin("operate", "console")
    tries = [desk.show("000000") for _ in range(MOST_WAITING + 1)]
    assert tries[-1].answer.code == "busy"
    assert not any(one.answer for one in tries[:-1])
    desk.service.step(DELAY_S)
    assert all(one.answer.code == "token" for one in tries[:-1])


@pytest.mark.parametrize(
    "payload",
    [b"", b"{", b"[]", {"digits": "12345", "address": "a"}, {"digits": "1234567", "address": "a"},
     {"digits": "12345x", "address": "a"}, {"digits": "123456"}, {"digits": "123456", "address": "a" * 65},
     {"digits": 123456, "address": "a"}, {"digits": "१२३४५६", "address": "a"}],
)  # fmt: skip
def test_what_is_no_try_is_refused_at_once_and_costs_none(desk, payload):
    desk.pairing.begin("operate", "console")
    asked = Asked(payload)
    desk.came = [asked]
    desk.service.step(0.0)
    assert asked.answer.code == "malformed"
    assert desk.events == []


@given(st.binary(max_size=80))
def test_no_bytes_break_it(payload):
    desk = Desk()
    asked = Asked(payload)
    desk.came = [asked]
    desk.service.step(0.0)
    assert asked.answer is not None


def test_who_lets_no_phones_in_cannot_show_a_code(desk):
    desk.pairing.begin("operate", "console")
    asked = Asked({"digits": "123456", "address": "a"}, source="drive")
    desk.came = [asked]
    desk.service.step(0.0)
    assert asked.answer.code == "denied"
    assert desk.show("123456").answer.accepted


def test_a_token_that_cannot_be_written_is_told_and_the_code_is_used_up(desk, wording):
    desk.pairing.begin("operate", "console")
    wording(desk.show("123456", name="broken").answer)
    assert desk.show("123456").answer is None


def test_the_end_answers_who_waits(desk):
    desk.pairing.begin("operate", "console")
    waits = desk.show("000000")
    desk.service.close()
    assert waits.answer.reason == NOT_GOOD
    assert not desk.pairing.cancel()


def test_comparing_takes_no_shortcut(monkeypatch):
    compared = []
    monkeypatch.setattr(
        "lbr.executive.service.pairing.hmac.compare_digest", lambda a, b: compared.append((len(a), len(b))) or a == b
    )
    pairing = Pairing(lambda: 0.0, lambda: "123456")
    pairing.attempt("111111", "a")
    pairing.begin("view", "console")
    pairing.attempt("111111", "a")
    assert compared == [(6, 6), (6, 6)]
    assert pairing_service.DELAY_S >= 1.0
