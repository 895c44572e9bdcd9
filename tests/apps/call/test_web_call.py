"""The call as a face: who asks goes along, what is too much is refused before it gets anywhere."""

from collections.abc import Iterator

import pytest

from lbr.apps.call.messages import KeepCommand, RingCommand, RingReply
from tests.apps.web.test_web_access import bearer, user
from tests.apps.web.test_web_cameras import STRANGER, signed_in
from tests.apps.web.test_web_hostile import asked_as_another
from tests.apps.web.test_web_server import Plain
from tests.apps.web.web_stage import Served, serving

RUNG = RingReply(accepted=True, id="abc", phase="ringing")


@pytest.fixture
def served(monkeypatch, tmp_path) -> Iterator[Served]:
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    users = (user("ann", "operate"), user("eve", "view"))
    with serving(Plain(), faces=("call",), users=users, simulated=False, requests_per_s=4000.0) as found:
        found.stage.wired |= {"call_ring", "call_keep"}
        found.stage.answer = lambda _request, _message: RUNG
        yield found


def test_who_asks_and_what_that_one_may_goes_along(served):
    answer = served.ask("POST", "/call", {"offer": "v=0"}, bearer("ann") | STRANGER)
    assert (answer.status, answer.json["id"], answer.json["phase"]) == (200, "abc", "ringing")
    served.ask("POST", "/call", {"offer": "v=0", "purpose": "watch"}, signed_in(served, "eve"))
    served.ask("POST", "/call", {"offer": "v=0"})
    asked = [message for request, message in served.stage.asked if request == "call_ring"]
    assert [(one.purpose, one.role) for one in asked] == [("talk", "operate"), ("watch", "view"), ("talk", "admin")]
    assert asked[0].by.startswith("ann at ")
    assert isinstance(asked[0], RingCommand)


def test_to_be_at_a_place_lets_no_page_call(served):
    assert asked_as_another(served, "POST", "/call") == 401
    assert served.ask("POST", "/call", {"offer": "v=0"}, STRANGER).status == 401
    assert served.ask("POST", "/call/abc", {}, STRANGER).status == 401
    assert served.ask("POST", "/call", {"offer": "v=0"}, {"Origin": "http://evil.example"}).status == 403
    assert served.stage.asked == []


@pytest.mark.parametrize(
    ("body", "status"),
    [
        ({"offer": "v=0\r\n" + "a=x\r\n" * 200_000}, 413),
        ({"offer": "v=0" + "x" * 40_000}, 400),
        ({"offer": ""}, 400),
        ({"offer": "v=0", "purpose": "listen"}, 400),
        ({"offer": 7}, 400),
        (b"garbage", 415),
        ({}, 400),
    ],
    ids=["a megabyte", "long", "empty", "purpose", "number", "garbage", "none"],
)
def test_what_is_no_offer_or_too_much_is_refused_before_it_gets_anywhere(served, body, status):
    assert served.ask("POST", "/call", body).status == status
    assert served.stage.asked == []


@pytest.mark.parametrize(("code", "status"), [("busy", 409), ("role", 403), ("malformed", 400), ("unreachable", 503)])
def test_what_the_call_refuses_has_its_sentence_and_code(served, code, status):
    served.stage.answer = lambda *_: RingReply(accepted=False, reason="no", code=code)
    answer = served.ask("POST", "/call", {"offer": "v=0"})
    assert (answer.status, answer.json) == (status, {"message": "no", "code": code})


def test_a_call_goes_on_and_is_left(served):
    served.ask("POST", "/call/abc")
    served.ask("POST", "/call/abc", {"leave": True})
    asked = [message for request, message in served.stage.asked if request == "call_keep"]
    assert asked == [KeepCommand(id="abc"), KeepCommand(id="abc", leave=True)]
    assert served.ask("POST", "/call/" + "x" * 60).status == 404
    served.stage.answer = lambda *_: RingReply(accepted=False, reason="there is no such call", code="unknown_name")
    assert served.ask("POST", "/call/abc").status == 404
