"""`POST /api/pair` on the real server, with an executive that is nothing but its answers."""

import json
import os
import threading

import pytest
from websockets.sync.client import connect

from lbr.apps.web.viewing import TALKS
from lbr.bus import tokens
from lbr.bus.door import LanUser
from lbr.executive.service.pairing_service import NOT_GOOD
from lbr.messages.leases import CommandReply
from lbr.messages.pairing import PairReply
from tests.apps.web.web_stage import Served, ending, serving
from tests.support.waiting import HANG_S, until

SECRET, FINGERPRINT = "s" * 43, "f" * 22
HASH = tokens.hashed(SECRET)
FOREIGN = {"Origin": "http://evil.example"}


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LBR_HOME", str(tmp_path_factory.mktemp("home") / "h"))
        with serving(legacy="off") as running:
            yield running


@pytest.fixture(autouse=True)
def executive(served):
    """Answers like the executive whose code is 123456, for a token of its own each time; counts what it was asked."""
    asked: list = []
    number = iter(range(1000))

    def answer(request, message):
        if request != "pair":
            return CommandReply(accepted=True)
        asked.append(message)
        if message.digits != "123456":
            return PairReply(accepted=False, reason=NOT_GOOD, code="token")
        name = f"phone-{threading.get_native_id()}-{next(number)}"
        token = tokens.Token(name=name, secret=SECRET, fingerprint=FINGERPRINT)
        return PairReply(accepted=True, token=str(token), name=name, role="operate", hash=HASH)

    served.stage.answer = answer
    return asked


def pair(served: Served, code: object = "123456", headers: dict | None = None, **more: object):
    return served.ask("POST", "/api/pair", {"code": code, "name": "Ann's phone", **more}, headers)


def test_the_right_code_gives_a_token_that_counts_at_once_and_restarts_nothing(served, executive):
    answer = pair(served, "123 456")
    assert answer.status == 200
    assert answer.headers["cache-control"] == "no-store"
    (asked,) = executive
    assert (asked.digits, asked.name, asked.address) == ("123456", "Ann's phone", "127.0.0.1")
    given = answer.json
    assert given["role"] == "operate"
    shown = {"Authorization": f"Bearer {given['token']}"}
    assert served.ask("POST", "/estop/reset", headers=shown).status == 200
    assert (
        served.ask("POST", "/estop/reset", headers={"Authorization": shown["Authorization"][:-30] + "x" * 30}).status
        == 401
    )
    assert any(user.name == given["name"] for user in served.stage.given), "the row is not gone on with"


def test_a_token_that_is_revoked_ends_what_its_own_client_opened_and_nothing_else(served):
    lost, kept = pair(served), pair(served)
    as_lost, as_kept = ({"Authorization": f"Bearer {one.json['token']}"} for one in (lost, kept))
    states = f"ws://127.0.0.1:{served.port}/ws"
    with connect(states, additional_headers=as_lost) as ends, connect(states, additional_headers=as_kept) as goes_on:
        served.stage.given = tuple(one for one in served.stage.given if one.name != lost.json["name"])
        assert ending(ends)[0] == TALKS
        for _ in range(5):
            goes_on.recv(timeout=HANG_S)
    assert served.ask("POST", "/estop/reset", headers=as_lost).status == 401
    assert served.ask("POST", "/estop/reset", headers=as_kept).status == 200


def test_a_token_that_is_added_by_hand_counts_at_once(served):
    shown = {"Authorization": f"Bearer {tokens.Token(name='plotter', secret=SECRET, fingerprint=FINGERPRINT)}"}
    assert served.ask("POST", "/estop/reset", headers=shown).status == 401
    served.stage.given = (*served.stage.given, LanUser(name="plotter", role="operate", secret=SECRET, hash=HASH))
    until(lambda: served.ask("POST", "/estop/reset", headers=shown).status == 200)


def test_it_gives_a_cookie_that_looks_and_does_nothing_else(served):
    answer = pair(served)
    cookie, *flags = answer.headers["set-cookie"].split("; ")
    assert {flag.lower() for flag in flags} >= {"httponly", "samesite=strict", "path=/"}
    assert SECRET not in cookie
    assert served.ask("GET", "/state", headers={"Cookie": cookie}).status == 200
    assert served.web._sessions.find(cookie.partition("=")[2], _mine()) != ""
    ended = served.ask("DELETE", "/sessions", headers={"Authorization": f"Bearer {answer.json['token']}"})
    assert ended.status == 204
    assert served.web._sessions.find(cookie.partition("=")[2], _mine()) == ""


def _mine() -> str:
    return f"user {os.getuid()}"


def test_a_wrong_code_gives_nothing_and_says_no_more_than_that(served):
    answers = [pair(served, code) for code in ("123457", "000000", "654321")]
    assert {(answer.status, answer.said) for answer in answers} == {(403, NOT_GOOD)}
    assert all("set-cookie" not in answer.headers for answer in answers)
    assert {answer.json["code"] for answer in answers} == {"token"}


@pytest.mark.parametrize(
    "body",
    [
        {}, {"code": 123456}, {"code": "12345"}, {"code": "1234567"}, {"code": "12345a"}, {"code": "1234 56"},
        {"code": ["1"]}, {"code": "123456", "role": "admin"}, {"code": "123456", "name": "x" * 81}, [], "123456", None,
    ],
)  # fmt: skip
def test_what_is_no_code_never_reaches_the_executive(served, executive, body):
    assert (
        served.ask("POST", "/api/pair", json.dumps(body).encode(), {"Content-Type": "application/json"}).status == 400
    )
    assert executive == []


def test_a_foreign_page_cannot_try_codes_and_an_address_holds_none(served, executive):
    assert pair(served, headers=FOREIGN).status == 403
    assert served.ask("GET", "/api/pair?code=123456").status == 404
    assert served.ask("POST", "/api/pair?code=123456").status == 400
    assert executive == []


@pytest.mark.parametrize(
    ("reply", "status"),
    [
        (PairReply(accepted=False, reason="too many", code="busy"), 429),
        (PairReply(accepted=False, reason="the disk is full", code="failed"), 503),
        (None, 503),
    ],
)
def test_an_executive_that_does_not_give_one_is_told(served, reply, status):
    served.stage.answer = lambda _request, _message: reply
    answer = pair(served)
    assert answer.status == status
    assert "token" not in answer.json


def test_no_code_and_no_token_is_told_or_published(served):
    token = pair(served).json["token"]
    pair(served, "654321")
    told = f"{served.stage.events}{served.stage.published}{served.stage.warned}"
    assert not any(secret in told for secret in ("123456", "654321", SECRET, token))


def test_who_shows_a_wrong_token_may_still_pair(served):
    answer = pair(served, headers={"Authorization": "Bearer nonsense"})
    assert answer.status == 200
