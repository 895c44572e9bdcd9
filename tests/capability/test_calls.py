"""A command is attributed to its sender, answered once, and a refusal is told where nobody waits for it."""

import time
from math import isnan

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.bus import stamp, wire
from lbr.bus.codec import Decoder
from lbr.capability.calls import UNSTAMPED, Answers, BusCall
from lbr.capability.overtaken import REMEMBERED_S, Overtaken
from lbr.messages.codes import Reason
from lbr.messages.leases import CommandReply
from lbr.messages.system import Stamp


class Asked:
    """The other end of a query, as far as an answer is concerned."""

    def __init__(self) -> None:
        self.answers: list[bytes] = []

    def __enter__(self) -> None:
        pass

    def __exit__(self, *_: object) -> None:
        pass

    def reply(self, _key: str, payload: bytes, **_others: object) -> None:
        self.answers.append(payload)


def called(attachment: bytes = b"", *, asked: Asked | None = None, away: bool = False):
    """A call, and what was told of its refusals."""
    told: list[tuple[str, str, str]] = []
    request = wire.Request("r/drive/command", b"{}", attachment, asked)
    call = BusCall(
        "command",
        None,
        request,
        "drive",
        lambda who, reply: told.append((who, reply.reason, reply.code)),
        away=away,
    )
    return call, told


def foreign(**fields: object) -> bytes:
    """A stamp of another machine."""
    known = {"source": "phone", "seq": 1, "mono_ns": 7_000_000_000, "wall_ns": 0, "boot": "afar"}
    return msgspec.json.encode(Stamp(**(known | fields)))  # type: ignore[arg-type]


def test_it_is_from_whom_its_stamp_says_and_no_older_than_it_is():
    before = time.monotonic()
    call, _ = called(stamp.make("phone", 3, sent_s=before - 2.0, waited_s=1.5))
    assert call.source == "phone"
    assert call.arrived == pytest.approx(before - 2.0)
    assert (call.sender_s, call.waited_s) == (pytest.approx(before - 2.0), 1.5)
    assert not call.remote


@pytest.mark.parametrize("attachment", [b"", b"{", b"\xff" * 40, b"[]", b'{"source": 3}', b"x" * 5000])
def test_one_without_a_stamp_that_can_be_read_is_a_strangers_and_came_now(attachment):
    before = time.monotonic()
    call, _ = called(attachment)
    assert call.source == UNSTAMPED
    assert before <= call.arrived <= time.monotonic()
    assert isnan(call.sender_s)


def test_a_name_without_end_is_cut_and_an_empty_one_is_a_strangers():
    assert len(called(foreign(source="p" * 900))[0].source) == 80
    assert called(foreign(source=""))[0].source == UNSTAMPED


def test_one_from_another_machine_is_remote_however_it_came():
    assert not called(foreign())[0].remote, "an old bridge of this machine may have no boot that we know"
    assert called(foreign(via="lan"))[0].remote
    assert called(foreign(), away=True)[0].remote
    assert not called(stamp.make("phone", 1), away=True)[0].remote, "it was sent beside us"
    assert called(foreign())[0].sender_s == 7.0


def test_the_clock_of_another_machine_dates_nothing_here():
    before = time.monotonic()
    assert before <= called(foreign(mono_ns=1))[0].arrived <= time.monotonic()


def test_only_the_first_answer_counts():
    asked = Asked()
    call, _ = called(asked=asked)
    call.reply(CommandReply(accepted=True, lease="a"))
    call.refuse("too late")
    assert [msgspec.json.decode(one) for one in asked.answers] == [{"accepted": True, "lease": "a"}]


@pytest.mark.parametrize("waits", [True, False])
@pytest.mark.parametrize("quiet", [True, False])
def test_a_refusal_is_an_event_unless_it_is_quiet_and_its_sender_waits(waits, quiet):
    call, told = called(stamp.make("phone", 1), asked=Asked() if waits else None)
    call.reply(CommandReply(accepted=False, reason="no", code="held"), quiet=quiet)
    assert told == ([] if waits and quiet else [("phone", "no", "held")])


def test_a_refusal_has_a_code_whoever_forgets_it():
    asked = Asked()
    call, told = called(asked=asked)
    call.reply(CommandReply(accepted=False, reason="no"))
    assert msgspec.json.decode(asked.answers[0])["code"] == told[0][2] == "refused"
    call, told = called(asked=Asked())
    call.refuse(Reason("held", "phone has it"), "busy")
    assert told == [(UNSTAMPED, "phone has it", "held")]


class Question:
    """A question that is under way."""

    def __init__(self, *payloads: bytes, done: bool = True) -> None:
        self.done = done
        self.replies = [wire.RawMessage("k", payload, b"", 0.0) for payload in payloads]


def test_answers_are_there_when_all_are_and_one_that_cannot_be_read_is_none():
    decoder = Decoder(CommandReply)
    asked = {
        "good": Question(b'{"accepted": true}', b'{"accepted": false}'),
        "mute": Question(),
        "mad": Question(b"\xff"),
        "wrong": Question(b'{"accepted": "maybe"}'),
        "slow": Question(done=False),
    }
    answers = Answers(asked, decoder)  # type: ignore[arg-type]
    assert answers.answers() is None
    asked["slow"].done = True
    assert answers.answers() == {
        "good": CommandReply(accepted=True),
        "mute": None,
        "mad": None,
        "wrong": None,
        "slow": None,
    }
    assert Answers({}, decoder).answers() == {}


def test_what_another_machine_said_before_its_stop_counts_as_said_before_it_however_late_it_comes():
    known = Overtaken()

    def came(name: str, sent_s: float, **fields: object) -> float:
        attachment = foreign(mono_ns=int(sent_s * 1e9), via="lan", **fields)
        request = wire.Request("r/drive/x", b"{}", attachment, None)
        return BusCall(name, None, request, "drive", lambda *_: None, overtaken=known).arrived

    stopped = came("stop", 7.0)
    assert came("command", 6.9) == stopped, "overtaken by the stop"
    assert came("command", 7.0) == stopped
    assert came("command", 7.1) > stopped
    assert came("command", 6.9, boot="elsewhere") > stopped, "another machine's clock says nothing of this one's"
    assert came("stop", 6.5) >= stopped
    assert came("command", 6.9) < came("command", 7.1), "an older stop that comes later takes nothing back"


@given(st.lists(st.tuples(st.booleans(), st.floats(0, 60), st.floats(0, 5)), max_size=30))
def test_nothing_that_was_sent_before_a_stop_of_late_is_dated_after_it(said):
    known, now, stops = Overtaken(), 1000.0, []
    for stops_now, sent_s, later_s in said:
        now += later_s
        found = Stamp(source="phone", seq=1, mono_ns=int(sent_s * 1e9), wall_ns=0, boot="afar")
        if stops_now:
            known.stopped(found, now)
            stops.append((sent_s, now))
        else:
            date = known.dated(found, now)
            assert date <= now
            if any(now - at <= REMEMBERED_S and sent_s < sent - 1e-6 for sent, at in stops):
                assert date <= max(at for _, at in stops)
            if not any(sent_s <= sent + 1e-6 for sent, _ in stops):
                assert date == now, "what was said after every stop is as new as it is"


def test_a_flood_of_machines_is_not_remembered_for_ever():
    known = Overtaken()
    for number in range(1000):
        known.stopped(Stamp(source="x", seq=1, mono_ns=1, wall_ns=0, boot=f"b{number}"), 1.0)
    assert len(known._stops) <= 64
