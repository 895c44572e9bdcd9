"""A stage runs capabilities as their processes do: what may be heard, published, asked and answered, and when."""

import pytest
from msgspec import Raw, Struct

from lbr.bus import keys, stamp, wire
from lbr.capability import Capability, Kind, NoSettings
from lbr.capability.config import InputWire, OutputWire, ProcessConfig
from lbr.capability.stage import Stage
from lbr.errors import DeviceError
from lbr.messages.motors import MotorSetpoint

pytestmark = pytest.mark.timeout(30)


def test_a_setpoint_without_the_drives_seal_reaches_no_port():
    bus, heard = Stage("r"), []

    class Motor(Capability[NoSettings]):
        def step(self):
            heard.extend(one.message.left for one in self.ctx.take("setpoint"))

    kind = Kind(name="motor", summary="turns", family="driver", entry=Motor, setpoints={"setpoint": MotorSetpoint})
    key = keys.port("r", "motor", "setpoint")
    wires = {"setpoint": (InputWire(key=key, source="drive", seal="ab" * 16),)}
    bus.add(config("motor", wiring=wires), kind)
    bus.bus.publish(key, MotorSetpoint(left=0.9, right=0.9), "intruder")
    bus.run(0.2)
    bus.put(key, MotorSetpoint(left=0.1, right=0.1), "drive")
    bus.run(0.5)
    assert heard == [0.1]
    assert [(one.kind, one.code) for one in bus.told] == [("refused", "denied")]


class Told(Struct):
    """A number."""

    number: float = 0.0


def config(name, **more):
    return ProcessConfig(
        robot="r", name=name, kind=name, settings=Raw(b"{}"), endpoints=(), home="/nonexistent", **more
    )


class Odd(Capability[NoSettings]):
    """Publishes what it is made to, and raises what it is asked for."""

    value: object = 1.0

    def step(self):
        self.ctx.publish("state", Told(number=self.value))

    def command(self, call):
        raise DeviceError("the line is cut", "unplugged") if call.message.number else RuntimeError("a defect")


ODD = Kind(name="odd", summary="is odd", family="app", entry=Odd, outputs={"state": Told}, commands={"do": Told})


@pytest.fixture
def odd():
    stage = Stage("r")
    key = keys.port("r", "odd", "state")
    stage.heard = []
    stage.listen(key, Told, lambda told: stage.heard.append(told.number))
    stage.capability = stage.add(config("odd", outputs={"state": (OutputWire(key=key),)}), ODD)
    stage.run(0.3)
    return stage


def test_a_value_that_its_declaration_does_not_allow_is_not_published_and_reported_once(odd):
    odd.capability.value = "fast"
    odd.run(0.1)
    seen = len(odd.heard)
    odd.run(1.0)
    assert (len(odd.heard), set(odd.heard)) == (seen, {1.0})
    assert [(one.kind, one.code, one.subject) for one in odd.told] == [("refused", "malformed", "odd")]
    odd.capability.value = 2.0
    odd.run(0.5)
    assert odd.heard[-1] == 2.0
    odd.capability.value = object()
    odd.run(0.5)
    assert len(odd.told) == 2


class Seldom(Capability[NoSettings]):
    """Reads a stream while it is made to, and keeps what came."""

    received_while_read = frozenset({"state"})
    reads = False

    def __init__(self, ctx):
        super().__init__(ctx)
        self.came: list[float] = []

    def step(self):
        if self.reads:
            self.came += [received.message.number for received in self.ctx.take("state")]


def test_what_is_received_while_it_is_read_has_no_subscriber_before_and_begins_with_the_newest_message(odd):
    key = keys.port("r", "odd", "state")
    kind = Kind(name="seldom", summary="reads", family="app", entry=Seldom, inputs={"state": Told})
    feeds = len(odd.bus.feeds[key])
    seldom = odd.add(config("seldom", wiring={"state": (InputWire(key=key, source="odd", history=4),)}), kind)
    odd.run(1.0)
    assert len(odd.bus.feeds[key]) == feeds
    seldom.reads = True
    odd.run(0.12)
    assert seldom.came[0] == 1.0
    odd.capability.value = 2.0
    odd.run(0.5)
    assert seldom.came[-1] == 2.0
    assert len(odd.bus.feeds[key]) == feeds + 1
    seldom.reads = False
    odd.run(4.0)
    assert len(odd.bus.feeds[key]) == feeds


class Choosy(Capability[NoSettings]):
    """Is woken by one of two streams."""

    rate_hz, woken_by_streams = 1.0, frozenset({"this"})

    def __init__(self, ctx):
        super().__init__(ctx)
        self.rounds = 0

    def step(self):
        self.rounds += 1


@pytest.mark.parametrize(("stream", "rounds"), [("this", 3), ("that", 0)])
def test_only_the_streams_that_it_names_wake_a_capability(stream, rounds):
    stage = Stage("r")
    keyed = {name: keys.port("r", "odd", name) for name in ("this", "that")}
    kind = Kind(name="choosy", summary="", family="app", entry=Choosy, inputs={"this": Told, "that": Told})
    wiring = {name: (InputWire(key=key, source="odd"),) for name, key in keyed.items()}
    choosy = stage.add(config("choosy", wiring=wiring), kind)
    stage.run(0.1)
    before = choosy.rounds
    for _ in range(3):
        stage.put(keyed[stream], Told(number=1.0), "odd")
        stage.run(0.1)
    assert choosy.rounds - before == rounds


def test_a_handler_that_raises_is_the_answer_before_its_process_ends(odd):
    asked = odd.command("odd", "do", Told(), "test")
    with pytest.raises(RuntimeError, match="a defect"):
        odd.run(0.1)
    odd.kill("odd")
    odd.run(0.05)
    answer = asked.answers()["odd"]
    assert (answer.accepted, answer.code) == (False, "failed")
    assert "a defect" in answer.reason


def test_a_device_that_is_lost_in_a_handler_is_the_answer_and_the_next_command_waits_for_it(odd):
    answer = odd.answer("odd", "do", Told(number=1.0))
    assert (answer.accepted, answer.code) == (False, "unplugged")
    assert odd.members["odd"].reporter.reported[::2] == ("degraded", "unplugged")
    odd.run(1.0)
    assert odd.members["odd"].reporter.reported[0] == "ready"


def test_a_question_to_one_that_is_frozen_ends_at_its_time_and_to_one_that_is_gone_at_once(odd):
    odd.members["odd"].frozen = True
    asked = odd.command("odd", "do", Told(), "test", 0.5)
    odd.run(0.49)
    assert asked.answers() is None
    odd.run(0.02)
    assert asked.answers() == {"odd": None}
    odd.kill("odd")
    asked = odd.command("odd", "do", Told(), "test", 0.5)
    odd.run(0.01)
    assert asked.answers() == {"odd": None}


def test_what_is_sent_later_in_a_round_is_the_newer(odd):
    first, second = (stamp.read(odd._outside.publisher("k", "s").put(Told())) for _ in range(2))
    assert first.mono_ns < second.mono_ns
    assert stamp.genuine(first, wire.encode(Told()), b"") is False
