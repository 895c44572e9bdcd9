import threading
from itertools import cycle
from types import SimpleNamespace

import pytest

from lbr.drivers.dynamixel import setup, table
from lbr.drivers.dynamixel.bus import Bus, open_bus
from lbr.drivers.dynamixel.setup import Setup, find_servos
from lbr.drivers.servos.bus_thread import READ, STOP, WRITE, BusThread
from lbr.drivers.servos.contract import SETTING_UP
from lbr.drivers.servos.protocol1.bus import ProtocolBus
from lbr.errors import DeviceError
from tests.drivers.servo_peers import MemoryLine, ServoChain, status
from tests.support.waiting import HANG_S, until


@pytest.fixture
def bus(chain):
    return on(chain)


def on(chain):
    """The bus of a chain in memory."""
    time = SimpleNamespace(now=100.0)
    return Bus(MemoryLine(chain, time, 1_000_000, 0.05), clock=lambda: time.now)


@pytest.fixture
def wired(tty):
    with open_bus(str(tty.path), margin_s=HANG_S) as bus:
        yield bus


def once(change):
    """Change the first answer only."""
    left = [change]

    def answer(request, usual):
        return left.pop()(request, usual) if left and usual else None

    return answer


def test_it_finds_reads_and_writes_servos(chain, bus):
    chain.dead.add(2)
    assert bus.scan(range(1, 4)) == [1, 3]
    assert bus.get(1, table.MODEL_NUMBER) == 12
    assert bus.put(1, table.LED, 1)
    assert chain.servos[1].table[25] == 1
    assert [motion and motion.position for motion in bus.read_motions((1, 3))] == [513, 515]
    bus.write_all(table.TORQUE_ENABLE.address, {1: b"\1", 3: b"\1"})
    assert chain.servos[1].torque == chain.servos[3].torque == 1023


def test_servos_are_looked_for_at_each_speed_on_request(tty, monkeypatch):
    patient = lambda path, **given: open_bus(path, **{**given, "margin_s": 0.5})  # noqa: E731 - a peer that is held up
    monkeypatch.setattr(setup, "open_bus", patient)
    found = list(find_servos(str(tty.path), (1_000_000, 57_600), (1, 3, 9)))
    assert found[:2] == [(1_000_000, 1), (1_000_000, 3)]
    assert {servo for _, servo in found} == {1, 3}


FAULTS = {
    "lost reply": lambda _request, _usual: b"",
    "corrupt sum": lambda _request, usual: usual[:-1] + bytes((usual[-1] ^ 1,)),
    "wrong id": lambda _request, usual: status(77, usual[5:-1]),
    "half a packet": lambda _request, usual: usual[:5],
    "a stray byte before it": lambda _request, usual: b"\x07" + usual,
    "a slipped header": lambda _request, usual: b"\xff" + usual,
    "a stray packet of the adapter before it": lambda _request, usual: status(0xFD, error=8) + usual,
    "an echo": lambda request, usual: request + usual,
    "too few bytes": lambda request, _usual: status(request[2], error=0x10),
    "babble": lambda _request, usual: bytes(range(256)) * 8 + usual,
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_one_answer_costs_no_state_and_never_gives_a_wrong_one(chain, bus, fault):
    chain.answer = once(FAULTS[fault])
    for servo in (1, 2, 3, 1, 2, 3):
        assert bus.read_motion(servo).position == 512 + servo


def test_what_goes_wrong_is_counted(chain, bus):
    for fault in ("lost reply", "corrupt sum", "wrong id"):
        chain.answer = once(FAULTS[fault])
        bus.read_motion(1)
    assert (bus.counts.timeouts, bus.counts.corrupt, bus.counts.retries) == (1, 2, 3)
    assert bus.strays[77] == 1


def test_an_answer_that_comes_too_late_does_not_pass_for_another(chain, bus):
    held = []
    chain.answer = lambda _request, usual: held.append(usual) or b""
    assert bus.read(1, 30, 6) is None
    chain.answer = lambda _request, usual: held[0] + usual if held and held.clear() is None else None
    chain.servos[1].put(36, 700)
    late = held[0]
    chain.answer = once(lambda _request, usual: late + usual)
    positions = {bus.read_motion(2).position, bus.read_motion(1).position}
    assert positions == {514, 700}


def test_an_adapter_that_hears_itself_passes_for_no_servo(chain, bus):
    chain.echo = True
    chain.dead.add(2)
    assert bus.get(1, table.TORQUE_LIMIT) == 1023
    assert bus.echo
    assert bus.scan(range(1, 4)) == [1, 3]
    assert bus.get(2, table.TORQUE_LIMIT) is None
    assert bus.put(3, table.LED, 1)


def test_a_servo_that_complains_of_its_voltage_answers_a_ping_like_an_echo(chain, bus):
    chain.servos[1].error = 1
    assert bus.ping(1).error == 1


def test_a_value_that_the_servo_would_refuse_does_not_reach_the_wire(chain, bus):
    with pytest.raises(ValueError, match=r"goal position 1024 is outside 0\.\.1023"):
        bus.put(1, table.GOAL_POSITION, 1024)
    assert not chain.log


def test_a_refused_write_is_told(chain, bus):
    chain.answer = lambda request, _usual: status(request[2], error=2)
    assert not bus.put(1, table.GOAL_POSITION, 3)


def test_the_adapter_reads_all_at_once_and_the_silent_are_none():
    chain = ServoChain(18, adapter=True)
    bus = on(chain)
    assert bus.find_adapter() == 5
    chain.dead.add(7)
    chain.log.clear()
    positions = [motion and motion.position for motion in bus.read_motions(range(1, 19))]
    assert positions == [None if servo == 7 else 512 + servo for servo in range(1, 19)]
    assert len(chain.log) == 1


def test_a_line_is_for_one_process_alone_and_says_where_it_went(tty, wired):
    with pytest.raises(DeviceError, match="busy"):
        open_bus(str(tty.path))
    tty.unplug()
    with pytest.raises(DeviceError, match="went away"):
        wired.read_motion(1)
    with pytest.raises(DeviceError, match="missing"):
        open_bus(str(tty.path))
    tty.plug()
    with open_bus(str(tty.path), margin_s=HANG_S) as other:
        assert other.read_motion(1).position == 513


def test_a_stop_goes_before_writes_and_writes_before_reads(bus):
    order, gate = [], threading.Event()
    owner = BusThread(bus)
    owner.start()
    blocked = owner.submit(lambda _bus: gate.wait(HANG_S), READ)
    until(blocked.running)
    jobs = [
        owner.submit(lambda _bus, name=name: order.append(name), priority)
        for name, priority in (("read", READ), ("write", WRITE), ("stop", STOP))
    ]
    gate.set()
    for job in jobs:
        job.result(HANG_S)
    assert order == ["stop", "write", "read"]
    assert owner.join(HANG_S)


def test_a_newer_job_takes_the_place_of_one_that_waits_under_its_key(bus):
    gate, done = threading.Event(), []
    owner = BusThread(bus)
    owner.start()
    blocked = owner.submit(lambda _bus: gate.wait(HANG_S), READ)
    until(blocked.running)
    first, last = (owner.submit(lambda _bus, n=n: done.append(n), WRITE, key="goals") for n in (1, 2))
    gate.set()
    last.result(HANG_S)
    assert first.cancelled()
    assert done == [2]
    assert owner.join(HANG_S)


def test_a_stop_is_on_the_wire_within_a_transaction_whatever_the_traffic(tty):
    tty.dead.add(2)
    servos = cycle((1, 2, 3))

    def background(bus):
        bus.read_motion(next(servos))
        return 0.0

    with open_bus(str(tty.path), margin_s=0.02) as bus:
        owner = BusThread(bus, background)
        owner.start()
        until(lambda: len(tty.log) > 10)
        owner.submit(lambda bus: bus.write_all(30, {1: b"\0\2"}), STOP).result(HANG_S)
        until(lambda: tty.writes(30))
        assert owner.join(HANG_S)


def test_a_job_that_fails_hurts_nobody_but_a_lost_line_ends_the_owner(tty, wired):
    owner = BusThread(wired)
    owner.start()
    with pytest.raises(ZeroDivisionError):
        owner.submit(lambda _bus: 1 // 0, READ).result(HANG_S)
    tty.unplug()
    with pytest.raises(DeviceError):
        owner.submit(lambda bus: bus.read_motion(1), READ).result(HANG_S)
    until(lambda: owner.failure is not None)
    assert owner.submit(lambda _bus: None, READ).cancelled()
    tty.plug()


WANTED = [(table.RETURN_DELAY, 0), (table.SHUTDOWN, 36)]


def set_up(setup, bus, servo):
    said = [SETTING_UP]
    while said[-1] == SETTING_UP and len(said) < 9:
        said.append(setup.prepare(bus, servo))
    return said[-1]


def test_setting_up_writes_only_what_differs_and_moves_nothing(chain, bus):
    told = []
    setup = Setup(WANTED, lambda *event: told.append(event))
    assert setup.prepare(bus, 1) == SETTING_UP
    assert chain.servos[1].table[5] == 0
    assert setup.prepare(bus, 1) == ""
    assert setup.prepare(bus, 1) == ""
    assert [request[5] for request in chain.log if request[4] == 3] == [5]
    assert setup.done == ((1, "return delay time"),)
    assert told == []
    assert setup.kept[1].temperature_limit == 70
    assert chain.servos[1].torque == 0


def test_a_servo_that_does_not_take_a_value_is_told_of_and_used(chain, bus):
    told = []
    chain.answer = lambda request, _usual: status(request[2]) if request[4] == 3 else None
    chain.servos[1].write = lambda _address, _data: None
    assert set_up(Setup(WANTED, lambda *event: told.append(event)), bus, 1) == ""
    assert [text for _, text, _ in told] == ["servo 1 does not take return delay time (250, not 0)"]


def test_what_a_servo_keeps_is_not_written_while_it_has_torque(chain, bus):
    told = []
    chain.servos[1].write(24, b"\1")
    assert Setup(WANTED, lambda *event: told.append(event)).prepare(bus, 1) == ""
    assert chain.servos[1].table[5] == 250
    assert "it has torque" in told[0][1]


def test_a_servo_that_answers_nothing_but_pings_is_taught_to_answer(chain, bus):
    chain.servos[1].table[16] = 0
    assert set_up(Setup([]), bus, 1) == ""
    assert chain.servos[1].table[16] == 2


def doubled(request, usual):
    return usual + usual if request[2] == 1 else None


def garbled(request, usual):
    return bytes(byte & 0x5F for byte in usual) if request[2] == 1 else None


@pytest.mark.parametrize(
    ("answer", "wrong"),
    [
        (doubled, "two servos with id 1"),
        (garbled, "two servos with id 1, or its cable is bad"),
    ],
)
def test_two_servos_with_one_id_are_found_out(chain, bus, answer, wrong):
    chain.answer = answer
    setup = Setup([])
    said = [setup.prepare(bus, 1) for _ in range(3)]
    assert wrong in said[-1]
    assert set_up(setup, bus, 2) == ""


def test_another_model_and_an_endless_servo_are_named(chain, bus):
    chain.servos[1].table[0] = 29
    chain.servos[2].put(8, 0)
    setup = Setup(WANTED)
    assert setup.prepare(bus, 1) == "is a model 29, not an AX-12A (12)"
    assert setup.prepare(bus, 2).startswith("is set to turn endlessly")
    assert not [request for request in chain.log if request[4] == 3]


def test_a_silent_servo_is_told_apart_from_a_bad_one(chain, bus):
    chain.dead.add(1)
    assert Setup([]).prepare(bus, 1) == "does not answer"


class SlowLine:
    """A line that hands over what a test puts there; each look at it takes as long as it may."""

    margin_s = 0.01

    def __init__(self):
        self.now, self.came = 0.0, []

    def busy_s(self, *_):
        return 0.001

    def send(self, _request):
        if self.came and self.came[0] == b"":
            self.came.pop(0)

    def read(self, wait_s):
        self.now += wait_s
        return b"" if not self.came or self.came[0] == b"" else self.came.pop(0)


def test_answers_that_a_busy_machine_hears_late_are_no_babble():
    line = SlowLine()
    bus = ProtocolBus(line, retries=0, clock=lambda: line.now)
    late, answer = status(1, b"\1" * 6), status(1, b"\2" * 6)
    assert bus.read(1, 36, 6) is None
    line.came = [late, b"", answer]
    assert bus.read(1, 36, 6).params == b"\2" * 6
    assert (bus.counts.babble, bus.counts.strays) == (0, 1)
    assert bus.read(1, 36, 6) is None
    line.came = [b"\x07" * 40, late[:5], b"", answer]
    assert bus.read(1, 36, 6).params == b"\2" * 6
    assert (bus.counts.babble, bus.counts.strays) == (45, 1)
