"""The context that tests of capabilities are given: the runtime's own, on a bus on which the test is everybody else."""

import inspect

import pytest
from msgspec import Struct
from msgspec.structs import replace

from lbr.capability import Kind, NoSettings, Rows
from lbr.capability.context import Call, Context, EmergencyStop
from lbr.messages.joints import Joint
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.speech import Phrase
from lbr.messages.system import Stamp
from lbr.testing import FakeCall, FakeContext


class Said(Struct):
    number: int


KIND = Kind(
    name="tested",
    summary="is tested",
    family="app",
    entry=object,
    settings=NoSettings,
    inputs={"ranges": Said},
    setpoints={"setpoint": Said},
    outputs={"state": Said, "frame": Said},
    requests={"go": Said},
    replies={"go": Said},
    rows=(Rows(Joint, learnt=True), Phrase),
)


@pytest.fixture
def ctx():
    return FakeContext(KIND)


FAKE = FakeContext(KIND)


@pytest.mark.parametrize(
    ("fake", "real"), [(FAKE, Context), (FakeCall("stop", None), Call), (FAKE.estop, EmergencyStop)]
)
def test_it_has_all_that_the_contract_names_with_the_same_parameters(fake, real):
    for name in real.__annotations__:
        assert hasattr(fake, name), name
    for name, function in vars(real).items():
        if inspect.isfunction(function) and not name.startswith("_"):
            assert (
                str(inspect.signature(getattr(type(fake), name))).partition(" ->")[0]
                == (str(inspect.signature(function)).partition(" ->")[0])
            ), name


def test_an_emergency_stop_that_is_pressed_is_engaged(ctx):
    ctx.engage_estop("smoke")
    assert (ctx.estop.engaged, ctx.estop.reason) == (True, "smoke")


def test_what_arrives_is_taken_once_and_the_newest_stays(ctx):
    assert ctx.latest("ranges") is None
    ctx.arrive("ranges", Said(1))
    ctx.now += 0.5
    ctx.arrive("ranges", Said(2), source="board", late_s=0.2)
    taken = ctx.take("ranges")
    assert [one.message.number for one in taken] == [1, 2]
    assert [one.source for one in taken] == ["ranges", "board"]
    assert taken[1].age_s(ctx.now) == pytest.approx(0.2)
    assert ctx.take("ranges") == []
    assert ctx.latest("ranges").message.number == 2
    ctx.unheard("ranges")
    assert ctx.latest("ranges") is None


def test_what_its_declared_type_does_not_allow_does_not_arrive(ctx):
    ctx.arrive("ranges", Said("far"))
    assert ctx.take("ranges") == []
    assert (ctx.codes, ctx.levels) == (["malformed"], ["warning"])


def test_another_machines_stamp_says_nothing_of_when_it_was_sent(ctx):
    ctx.arrive("setpoint", Said(1), stamp=Stamp(source="phone", seq=1, wall_ns=0, mono_ns=0, boot="elsewhere"))
    assert ctx.latest("setpoint").arrived == ctx.now


def test_what_is_published_is_kept_by_output_and_forgotten_for_those_who_ask(ctx):
    ctx.publish("state", Said(1))
    ctx.publish("frame", Said(2), taken_s=99.0)
    assert [one.number for one in ctx.said("state")] == [1]
    assert ctx.taken_s == [99.0]
    ctx.forget("frame")
    assert ctx.answered == {"state"}
    assert ctx.said("frame")


def test_a_value_that_its_declared_type_does_not_allow_is_a_defect(ctx):
    with pytest.raises(AssertionError, match="does not declare"):
        ctx.publish("state", Said("fast"))
    assert ctx.published == []


def test_a_question_is_answered_as_the_test_says_or_waits(ctx):
    waits = ctx.ask("go", Said(1), 0.1)
    assert waits.answers() is None
    ctx.replies["go"] = {"drive": Said(2), "joints": Said(3)}
    assert ctx.ask("go", Said(1), 0.1).answers() == {"drive": Said(2), "joints": Said(3)}
    assert ctx.ask("go", Said(1), 0.1, only={"drive"}).answers() == {"drive": Said(2)}
    waits.given = {}
    assert waits.answers() == {}
    assert [one.request for one in ctx.asked] == ["go"] * 3


def test_who_is_wired_and_lives_is_whoever_the_test_says(ctx):
    assert (ctx.sources("ranges"), ctx.targets("go"), ctx.alive("drive")) == (("ranges",), ("go",), True)
    ctx.wired, ctx.gone = {"ranges": ("board",), "go": ()}, {"drive"}
    assert (ctx.sources("ranges"), ctx.targets("go"), ctx.alive("drive")) == (("board",), (), False)


def test_a_call_is_answered_once_and_says_why_it_was_refused(ctx):
    call = FakeCall("stop", StopCommand())
    assert (call.answer, call.refused) == (None, "")
    call.refuse("not now")
    assert (call.answer, call.refused) == (CommandReply(accepted=False, reason="not now", code="refused"), "not now")
    with pytest.raises(AssertionError, match="twice"):
        call.reply(CommandReply(accepted=True))


def test_rows_are_given_learnt_by_their_key_and_what_no_context_has_is_refused():
    neck = Joint(name="neck", device_id=1, lower_rad=-1.0, upper_rad=1.0, speed_rps=1.0)
    hello = Phrase(name="hello", language="en", text="Hello.")
    ctx = FakeContext(KIND, given=(neck, hello))
    assert (ctx.rows(Joint), ctx.rows(Phrase)) == ((neck,), (hello,))
    faster = replace(neck, speed_rps=2.0)
    ctx.learn(faster)
    assert (ctx.rows(Joint), ctx.kept) == ((faster,), [(faster,)])
    with pytest.raises(ValueError, match="learns no rows"):
        ctx.learn(hello)
    with pytest.raises(TypeError, match="no 'joints'"):
        FakeContext(KIND, joints=(neck,))


def test_what_a_capability_tells_is_kept(ctx):
    ctx.event("fallen", "it fell", level="warning", data={"roll": 1})
    assert (ctx.told("fallen"), ctx.levels, ctx.data) == (["it fell"], ["warning"], [{"roll": 1}])
    ctx.warn("no voltage")
    ctx.ready()
    assert ctx.health == ["no voltage", "ready"]
    ctx.engage_estop("smoke")
    ctx.estop.acknowledge(stopped=True)
    assert (ctx.latched, ctx.estop.acknowledged) == (["smoke"], [(True, "")])
