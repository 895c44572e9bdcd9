"""Who may call, who is first, and what ends a call: decided without clock, bus or media."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.call.desk import CONNECT_S, SILENT_S, Close, Connect, Desk, fault_of, without_names
from lbr.apps.call.kind import CallSettings
from lbr.apps.call.messages import RingCommand
from lbr.messages.codes import MEANINGS

OFFER = """v=0
o=- 1 2 IN IP4 127.0.0.1
m=audio 9 UDP/TLS/RTP/SAVPF 111
m=video 9 UDP/TLS/RTP/SAVPF 96
a=rtpmap:96 VP8/90000
a=candidate:1 1 udp 2113937151 192.0.2.9 51234 typ host
a=candidate:2 1 udp 2113937151 5f0c0a5e-1111-4444-8888-0123456789ab.local 51235 typ host
a=end-of-candidates
""".replace("\n", "\r\n")


def desk(**settings):
    names = iter(range(1000))
    return Desk(CallSettings(**settings), make_id=lambda: f"g{next(names)}")


def ring(at, now=0.0, purpose="talk", who="ann", role="operate", offer=OFFER):
    return at.ring(RingCommand(purpose=purpose, offer=offer, by=who, role=role), now)


def kinds(at):
    return [one.kind for one in at.news]


def test_a_call_rings_until_a_person_answers_it():
    at = desk()
    assert ring(at).phase == "ringing"
    assert at.orders == []
    assert at.answer("console", 1.0) is None
    assert at.orders == [Connect("g0", "talk", OFFER)]
    at.answered("g0", "v=0 answer")
    assert at.keep("g0", 1.5).answer == "v=0 answer"
    at.connected("g0")
    assert (at.phase, kinds(at)) == ("talking", ["call_rings", "call_answered", "call_connected"])
    assert at.answer("console", 2.0).code == "idle"


def test_a_row_has_each_call_answered_at_once():
    at = desk(answer="at_once")
    assert ring(at).phase == "connecting"
    assert at.orders == [Connect("g0", "talk", OFFER)]


def test_two_callers_at_once_the_second_is_told_who_was_first():
    at = desk(answer="at_once")
    ring(at, who="ann at 192.0.2.1")
    reply = ring(at, who="eve")
    assert (reply.accepted, reply.code) == (False, "busy")
    assert "ann at 192.0.2.1" in reply.reason
    assert ring(at, purpose="watch", who="eve", role="view").accepted
    third = ring(at, purpose="watch", who="bob")
    assert (third.code, "WebRTC" in third.reason) == ("busy", True)


@pytest.mark.parametrize(
    ("purpose", "role", "allowed"),
    [("talk", None, False), ("talk", "view", False), ("talk", "operate", True), ("watch", "view", True), ("watch", None, False)],
)  # fmt: skip
def test_who_may_call_the_row_says(purpose, role, allowed):
    reply = ring(desk(), purpose=purpose, role=role)
    assert (reply.accepted, reply.code) == ((True, "") if allowed else (False, "role"))
    assert not ring(desk(callers="admin"), role="operate").accepted
    assert ring(desk(callers="view"), role="view").accepted


def test_a_display_shows_a_caller_and_leaves_with_the_caller():
    at = desk(answer="at_once")
    assert ring(at, purpose="display").code == "idle"
    ring(at)
    assert ring(at, purpose="display", role="view").code == "role"
    assert ring(at, purpose="display").id == "g1"
    at.connected("g0")
    at.connected("g1")
    assert at.displays == 1
    assert at.finish("console", declined=False) is None
    assert [one for one in at.orders if isinstance(one, Close)] == [Close("g0"), Close("g1")]
    assert not at.any
    told = at.keep("g0", 5.0)
    assert (told.accepted, told.phase, told.reason) == (True, "idle", "console ended it")


def test_a_page_that_falls_silent_has_left():
    at = desk(answer="at_once")
    ring(at)
    at.connected("g0")
    at.keep("g0", 5.0)
    at.tick(5.0 + SILENT_S)
    assert at.phase == "talking"
    at.tick(5.1 + SILENT_S)
    assert (at.phase, at.last.code) == ("idle", "holder_gone")


@pytest.mark.parametrize(("answer", "after", "code"), [("ask", 45.0, "timeout"), ("at_once", CONNECT_S, "unreachable")])
def test_what_is_not_answered_or_finds_no_way_ends(answer, after, code):
    at = desk(answer=answer)
    ring(at)
    at.keep("g0", after)
    at.tick(after)
    assert at.any
    at.tick(after + 0.1)
    assert (at.any, at.last.code) == (False, code)


def test_an_owner_declines_what_rings_and_ends_what_goes_on():
    at = desk()
    assert at.finish("console", declined=True).code == "idle"
    ring(at)
    assert at.finish("console", declined=True) is None
    assert at.last.text == "console declined it"
    ring(at)
    at.answer("console", 0.0)
    assert at.finish("console", declined=True).code == "not_possible"
    assert at.finish("console", declined=False) is None


def test_a_page_leaves_and_one_of_before_a_restart_is_told_so():
    at = desk(answer="at_once")
    ring(at)
    assert at.keep("g0", 0.1, leave=True).phase == "idle"
    assert at.orders[-1] == Close("g0")
    gone = at.keep("older", 0.2)
    assert (gone.accepted, gone.code) == (False, "unknown_name")


def test_an_offer_is_a_picture_in_vp8_and_at_most_one_sound():
    assert fault_of(OFFER) is None
    assert fault_of("hello").code == "malformed"
    assert fault_of(OFFER + "m=application 9 UDP/DTLS/SCTP webrtc-datachannel\r\n").code == "malformed"
    assert fault_of(OFFER + "m=video 9 UDP/TLS/RTP/SAVPF 97\r\n").code == "malformed"
    assert fault_of(OFFER.replace("VP8", "H264")).code == "not_possible"


def test_addresses_that_would_have_to_be_looked_up_are_left_out():
    kept = without_names(OFFER)
    assert "192.0.2.9" in kept
    assert ".local" not in kept
    assert "end-of-candidates" not in kept
    assert "example.org" not in without_names("v=0\r\na=candidate:1 1 udp 1 example.org 1 typ host\r\n")


@given(st.text(max_size=400) | st.lists(st.sampled_from(OFFER.splitlines()), max_size=12).map("\n".join))
def test_no_offer_breaks_the_desk(text):
    at = desk(answer="at_once")
    if text:
        reply = ring(at, offer=text)
        assert reply.accepted or reply.code in MEANINGS
        assert reply.accepted == (fault_of(text) is None)
    without_names(text)


STEPS = st.lists(
    st.tuples(
        st.sampled_from(["ring", "watch", "display", "keep", "leave", "answer", "decline", "end", "connected", "lost", "tick"]),
        st.integers(0, 12),
        st.floats(0.0, 6.0),
    ),
    max_size=60,
)  # fmt: skip


@given(STEPS, st.sampled_from(["ask", "at_once"]))
def test_there_is_never_more_than_one_caller_nor_more_pictures_than_the_row_allows(steps, answer):
    at, now = desk(answer=answer), 0.0
    for what, n, span in steps:
        now += span
        if what in {"ring", "watch", "display"}:
            ring(at, now, "talk" if what == "ring" else what, who=f"who{n}")
        elif what in {"keep", "leave"}:
            at.keep(f"g{n}", now, leave=what == "leave")
        elif what in {"answer", "decline", "end"}:
            at.answer("console", now) if what == "answer" else at.finish("console", declined=what == "decline")
        elif what == "connected":
            at.connected(f"g{n}")
        elif what == "lost":
            at.lost(f"g{n}", at.last)
        at.tick(now)
        talking = [one for one in at._guests.values() if one.purpose == "talk"]
        assert len(talking) <= 1
        assert at.pictured <= 2
        assert at.displays == 0 or talking
    opened = {one.id for one in at.orders if isinstance(one, Connect)}
    closed = {one.id for one in at.orders if isinstance(one, Close)}
    assert opened - closed <= set(at._guests)
