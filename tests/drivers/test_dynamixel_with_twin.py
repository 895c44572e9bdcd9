"""The driver's bus against the emulated one, which was written apart from it; the time between them is the test's."""

import msgspec
import pytest

from lbr.drivers.dynamixel import table
from lbr.drivers.dynamixel.bus import Bus
from lbr.drivers.dynamixel.recovery import recovery
from lbr.drivers.dynamixel.setup import Setup
from lbr.drivers.servos.line import ServoLine
from lbr.drivers.servos.poller import Poller
from lbr.simulation.devices.dynamixel import DynamixelFaults
from lbr.simulation.devices.dynamixel.bus import DynamixelBus
from lbr.simulation.devices.dynamixel.dongle import Usb2Ax
from lbr.simulation.devices.dynamixel.servo import AxServo

IDS = range(1, 19)
WANTED = [(table.RETURN_LEVEL, 2), (table.RETURN_DELAY, 0), (table.SHUTDOWN, 36)]


class TwinLine(ServoLine):
    """A line straight to an emulated bus; waiting is what moves the clock."""

    def __init__(self, bus):
        self.emulated = bus
        self.now = 100.0
        self.name, self.baud, self.margin_s = "of the test", 1_000_000, 0.01
        self._came = b""

    def send(self, data):
        self._came += self.emulated.feed(data, self.now, 1e6)
        return True

    def read(self, wait_s):
        until_s = self.now + (max(wait_s, 1e-6) if wait_s else 0.0)
        while True:
            self._came += self.emulated.poll(self.now)
            due = self.emulated.next_due()
            if self._came or due is None or due > until_s:
                break
            self.now = max(self.now, due)
        if not self._came:
            self.now = until_s
        data, self._came = self._came, b""
        return data

    def close(self):
        pass


class Rig:
    """Eighteen servos, each in a place of its own, and the sweep that reads them."""

    def __init__(self, dongle=None, **faults):
        self.servos = [AxServo(number, position_rad=0.1 * (number - 9)) for number in IDS]
        emulated = DynamixelBus(self.servos, dongle=Usb2Ax(dongle) if dongle else None, seed=4)
        self.line = TwinLine(emulated)
        self.told = []
        self.bus = Bus(self.line, clock=self.clock)
        self.setup = Setup(WANTED, self.tell)
        self.poller = Poller(IDS, self.clock, 0.01, self.setup.prepare, self.tell)
        if dongle:
            assert self.bus.find_adapter() == dongle
        emulated.faults = msgspec.convert(faults, DynamixelFaults)

    def clock(self):
        return self.line.now

    def tell(self, *event):
        self.told.append(event)

    def sweep(self, seconds):
        until_s = self.line.now + seconds
        states = []
        last = self.poller.snapshot.sweep
        while self.line.now < until_s:
            wait_s = self.poller.turn(self.bus)
            self.line.now += wait_s
            if self.poller.snapshot.sweep != last:
                last = self.poller.snapshot.sweep
                states.append(self.poller.snapshot)
        return states

    def raw(self, number):
        return 512 + round(self.servos[number - 1].felt.position_rad / table.RAD_PER_STEP)


@pytest.mark.parametrize("dongle", [None, 4, 5])
def test_servos_as_they_come_from_the_factory_are_set_up_and_swept(dongle):
    rig = Rig(dongle)
    snapshot = rig.sweep(2.0)[-1]
    assert {number: seen.motion.position for number, seen in snapshot.servos.items()} == {n: rig.raw(n) for n in IDS}
    assert not any(seen.reason or seen.slow.enabled for seen in snapshot.servos.values())
    assert {servo.return_delay_s for servo in rig.servos} == {0.0}
    assert rig.bus.counts.corrupt == rig.bus.counts.strays == 0
    assert rig.poller.snapshot.sweeps_hz > 60.0
    assert sorted(rig.setup.done) == [(number, "return delay time") for number in IDS]


FAULTS = [
    {"drop": 0.05},
    {"bit_flip": 0.05},
    {"garbage": 0.1},
    {"stray": 0.1},
    {"half": 0.05},
    {"pieces": 0.3},
    {"late": 0.05},
    {"echo": True},
    {"babbling": True},
]


@pytest.mark.parametrize("dongle", [None, 5])
@pytest.mark.parametrize("faults", FAULTS, ids=lambda faults: next(iter(faults)))
def test_on_a_bad_line_every_state_is_true(faults, dongle):
    rig = Rig(dongle, **faults)
    states = rig.sweep(1.1)
    seen = [(number, seen.motion) for state in states for number, seen in state.servos.items() if seen.motion]
    assert len(seen) > 100
    assert all(motion.position == rig.raw(number) for number, motion in seen)
    assert all(
        state.servos[number].slow is None or not state.servos[number].slow.enabled for state in states for number in IDS
    )


@pytest.mark.parametrize(
    ("faults", "said"),
    [
        ({"silent": [7]}, "does not answer"),
        ({"unpowered": [7]}, "does not answer"),
        ({"other_baud": [7]}, "does not answer"),
        ({"wrong_model": [7]}, "not an AX-12A"),
        ({"duplicate": [7]}, "two servos with id 7"),
    ],
)
def test_a_bad_servo_is_named_and_slows_nobody(faults, said):
    rig = Rig(**faults)
    snapshot = rig.sweep(2.0)[-1]
    assert said in snapshot.servos[7].reason
    assert not any(seen.reason for number, seen in snapshot.servos.items() if number != 7)
    assert snapshot.sweeps_hz > 55.0


def test_servos_that_lose_their_supply_come_back_by_themselves():
    rig = Rig()
    rig.sweep(1.0)
    rig.line.emulated.faults = DynamixelFaults(brown_out=True)
    assert all(seen.reason for seen in rig.sweep(2.5)[-1].servos.values())
    rig.line.emulated.faults = DynamixelFaults()
    assert not any(seen.reason for seen in rig.sweep(4.5)[-1].servos.values())


def test_an_overload_is_seen_and_recovered_once_its_cause_is_gone():
    rig = Rig()
    rig.sweep(1.0)
    rig.line.emulated.faults = DynamixelFaults(overload=(3,), hot=(4,))
    servos = rig.sweep(0.5)[-1].servos
    assert (servos[3].error, servos[3].slow.limit) == (0x20, 0)
    assert (servos[4].error & 0x04, servos[4].slow.limit) == (0x04, 0)
    assert recovery(3, rig.setup.kept[3])(rig.bus) == "latches again at once"
    assert "is still too hot" in recovery(4, rig.setup.kept[4])(rig.bus)
    rig.line.emulated.faults = DynamixelFaults()
    assert recovery(3, rig.setup.kept[3])(rig.bus) == ""
    servos = rig.sweep(0.5)[-1].servos
    assert (servos[3].error, servos[3].slow.limit) == (0, 1023)


@pytest.mark.parametrize("dongle", [None, 5])
def test_a_stop_waits_no_longer_than_the_wire_is_taken_though_an_answer_is_lost(dongle):
    rig = Rig(dongle, drop=1.0)
    bus = Bus(rig.line, clock=rig.clock, urgent=lambda: True)
    bus.adapter = dongle
    began = rig.line.now
    assert bus.read_motions([7]) == [None]
    assert bus.cut_short
    assert rig.line.now - began < 0.0035
    began = rig.line.now
    bus.write_all(table.GOAL_POSITION.address, {7: b"\0\2"})
    assert rig.line.now == began
