"""The call as a process: what it tells, and what it leaves alone."""

import sys

import msgspec
import pytest

from tests.support import needs
from tests.support.waiting import until

needs.modules("aiortc", "PIL")

from lbr.apps.call.capability import Call  # noqa: E402
from lbr.apps.call.kind import KIND, CallSettings  # noqa: E402
from lbr.apps.call.messages import CallWord, KeepCommand, RingCommand  # noqa: E402
from lbr.messages.camera import CameraState, JpegFrame  # noqa: E402
from lbr.testing.context import FakeCall, FakeContext  # noqa: E402
from tests.apps.call.call_bench import GREY, Caller, jpeg  # noqa: E402
from tests.apps.call.test_call_desk import OFFER  # noqa: E402

ON = CameraState(on=True, phase="streaming", device="/dev/video0")
OFF = CameraState(on=False, phase="off", device="/dev/video0")


class Bench:
    def __init__(self, **settings):
        self.ctx = FakeContext(KIND, CallSettings(**settings), simulated=True, name="call")
        self.call = Call(self.ctx)
        self.call.open()

    def say(self, name, message=None, source="console"):
        asked = FakeCall(name, message or CallWord(), source=source)
        self.call.command(asked)
        return asked.answer

    def ring(self, offer=OFFER, purpose="talk", role="operate", by="ann"):
        return self.say("ring", RingCommand(purpose=purpose, offer=offer, by=by, role=role))

    def keep(self, name, **more):
        return self.say("keep", KeepCommand(id=name, **more))

    def round(self, camera=ON, source="camera_front", span_s=0.05):
        self.ctx.now += span_s
        if camera is not None:
            self.ctx.arrive("cameras", camera, source=source)
            if camera.on:
                self.ctx.arrive("frames", JpegFrame(jpeg(GREY)), source=source)
        self.call.step()
        return self.ctx.said("state")[-1]


@pytest.fixture
def bench():
    made = []

    def make(**settings):
        made.append(Bench(**settings))
        return made[-1]

    yield make
    for one in made:
        one.call.close()


def test_it_asks_nothing_of_the_robot_that_moves_or_switches_a_camera():
    assert KIND.requests == {}
    assert not KIND.moves
    assert KIND.setpoints == {}


def test_a_call_is_answered_at_the_console_and_ended_there(bench):
    found = bench()
    assert found.say("answer").code == "idle"
    name = found.ring().id
    assert found.round().phase == "ringing"
    assert found.say("answer").accepted
    until(lambda: found.round() and found.keep(name).phase == "idle", what="an offer of nothing to be refused")
    assert found.keep(name).code == "malformed"
    kinds = [kind for kind, _ in found.ctx.events]
    assert kinds == ["call_rings", "call_answered", "call_ended"]


def test_without_the_extra_it_says_what_to_install_and_lets_no_page_in(bench, monkeypatch):
    monkeypatch.setitem(sys.modules, "lbr.apps.call.media", None)
    found = bench(answer="at_once")
    reply = found.ring()
    assert (reply.accepted, reply.code) == (False, "not_possible")
    assert "lbr[telepresence]" in reply.reason
    assert found.round().lacks == reply.reason
    assert found.ctx.health == [reply.reason]
    assert found.say("answer").code == "idle"


def test_a_whole_call_with_a_camera_that_is_switched_off_in_it(bench):
    found, ann = bench(answer="at_once"), Caller()
    try:
        name = found.ring(ann.offer(), by="ann at 192.0.2.7").id
        ann.take(until(lambda: found.round() and found.keep(name).answer))
        until(lambda: found.round().phase == "talking")
        told = found.keep(name)
        assert (told.picture, told.hears, told.seen) == ("", "tone", False)
        assert found.ctx.said("state")[-1].camera == "front"
        for _ in range(30):
            state = found.round(OFF)
        assert (state.camera, "is off" in state.picture) == ("", True)
        assert found.keep(name).phase == "talking"
        for _ in range(30):
            state = found.round(None)
        found.ctx.gone.add("camera_front")
        assert found.round(None).picture == "no camera is there"
        assert found.say("end").accepted
        assert found.keep(name).reason == "console ended it"
        assert found.ctx.asked == []
    finally:
        ann.close()


def test_a_browser_that_is_killed_is_missed_by_its_word_and_by_its_connection(bench):
    found, ann = bench(answer="at_once"), Caller()
    name = found.ring(ann.offer()).id
    ann.take(until(lambda: found.round() and found.keep(name).answer))
    until(lambda: found.round().phase == "talking")
    ann.close()
    until(lambda: found.round(span_s=0.5).phase == "idle")
    assert found.keep(name).code in {"holder_gone", "unreachable"}
    assert found.ring().accepted


def test_who_is_refused_is_written_down(bench):
    found = bench()
    assert found.ring(role=None, by="127.0.0.1").code == "role"
    assert found.ctx.events == [
        ("call_refused", "127.0.0.1 (talk): this needs the role 'operate', and you have 'none'")
    ]


def test_without_a_call_no_pictures_are_read_and_it_is_known_which_camera_a_call_would_show(bench):
    found = bench()
    found.round(source="camera_front")
    assert found.round(source="camera_rear").camera == "front"
    assert len(found.ctx.take("frames")) == 1, "the test is the first to read, and gets the newest"
    found.round(msgspec.structs.replace(ON, on=False, phase="off"), source="camera_front")
    assert found.round(source="camera_rear").camera == "rear"


def test_the_picture_of_a_call_is_of_the_camera_that_was_there_first(bench):
    found = bench()
    found.ring()
    for _ in range(3):
        found.round(source="camera_front")
        state = found.round(source="camera_rear")
    assert state.camera == "front"
    for _ in range(30):
        state = found.round(source="camera_rear")
    assert state.camera == "rear"
