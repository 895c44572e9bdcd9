"""The driver's bus against the emulated main board, which was written apart from it; the time between them is the test's."""

import msgspec

from lbr.drivers.serial_line import SerialLine
from lbr.robots.uxa90.driver import frames, packets
from lbr.robots.uxa90.driver.bus import Bus
from lbr.robots.uxa90.driver.messages import COUNT_RAD, ConfigureCommand, InquireCommand
from lbr.robots.uxa90.driver.packets import REGISTERS
from lbr.robots.uxa90.driver.poller import Poller
from lbr.robots.uxa90.driver.requests import configuration, inquiry
from lbr.robots.uxa90.driver.targets import ServoTargets
from lbr.robots.uxa90.twin import Uxa90Faults, Uxa90Row
from lbr.robots.uxa90.twin.board import MainBoard

IDS = range(25)


class TwinLine(SerialLine):
    """A line straight to an emulated main board; waiting is what moves the clock."""

    def __init__(self, board):
        self.board, self.now, self.baud = board, 100.0, 115_200
        self._came = b""

    def send(self, data):
        self._came += self.board.feed(data, self.now, 115_200)
        return True

    def read(self, wait_s):
        until_s = self.now + max(wait_s, 1e-6)
        while True:
            self._came += self.board.poll(self.now)
            due = self.board.next_due()
            if self._came or due is None or due > until_s:
                break
            self.now = max(self.now + 1e-6, due)
        if not self._came:
            self.now = until_s
        data, self._came = self._came, b""
        return data

    def close(self):
        pass


class Rig:
    """Twenty-five servos in the places where the robot sits, and the sweep that reads them."""

    def __init__(self, *, pc=True, **row):
        self.board = MainBoard(msgspec.convert(row, Uxa90Row), seed=4)
        self.line = TwinLine(self.board)
        self.bus = Bus(self.line, 0.03, clock=lambda: self.line.now)
        self.poller = Poller(IDS, lambda: self.line.now, 0.05, "plausible", 5, moving=lambda _servo: False)
        self.poller.reading = True
        if pc:
            self.bus.say(frames.TAKE_CONTROL)
            self.wait(0.3)

    def wait(self, seconds):
        until_s = self.line.now + seconds
        while self.line.now < until_s:
            self.bus.settle(0.01)
            self.line.now += 0.01

    def suffer(self, **faults):
        self.board.faults = msgspec.convert(faults, Uxa90Faults)

    def sweep(self, seconds, each=lambda: None):
        until_s = self.line.now + seconds
        while self.line.now < until_s:
            self.line.now += self.poller.turn(self.bus)
            each()

    def places(self):
        return {servo.number: round(127 + servo.felt.position_rad / COUNT_RAD) for servo in self.board.servos}

    def believed(self):
        return {servo: seen.position for servo, seen in self.poller.seen.items() if seen.trusted}


def test_without_pc_control_nobody_answers_and_moves_do_nothing():
    rig = Rig(pc=False)
    before = rig.places()
    rig.bus.write([(23, packets.move(23, 0, 200))])
    rig.sweep(1.0)
    assert not rig.believed()
    assert rig.places() == before


def test_moves_are_obeyed_and_answered_and_passive_and_brake_as_well():
    rig = Rig()
    answers = rig.bus.write([(23, packets.move(23, 0, 100)), (24, packets.move(24, 0, 130))])
    assert answers is not None
    assert [answer.position for answer in answers] == [127, 127]
    rig.sweep(1.0)
    assert (rig.believed()[23], rig.believed()[24]) == (100, 130)
    assert rig.bus.write([(23, packets.passive(23))]) is not None
    rig.bus.say(packets.BREAK_ALL)
    rig.sweep(1.0)
    assert rig.believed() == rig.places()


def test_the_main_board_says_who_it_is_and_servos_what_they_keep():
    rig = Rig()
    for what, text in (("serial", "6012000010005"), ("firmware", "C9 00")):
        assert inquiry(InquireCommand(what=what), IDS)(rig.bus).text == text
    assert len(inquiry(InquireCommand(what="zeros"), IDS)(rig.bus).values) == 31
    for name, register in REGISTERS.items():
        if register.read is not None:
            said = inquiry(InquireCommand(what=name, id=23), IDS)(rig.bus)
            assert said.accepted, (name, said.reason)
    said = configuration(ConfigureCommand(what="boundary", id=23, values=(20, 200)), IDS)(rig.bus)
    assert (said.accepted, said.values) == (True, (20, 200)), said.reason
    rig.sweep(0.5)
    assert rig.believed() == rig.places()


def test_the_answer_to_the_brake_is_expected_so_that_it_costs_no_position_its_belief():
    rig = Rig()
    targets = ServoTargets(IDS, rig.poller.seen, lambda: rig.line.now, rig.line.wire_s)
    targets.brake(rig.bus)
    rig.wait(0.3)
    assert (rig.bus.unasked, rig.bus.counts.babble, rig.bus.counts.timeouts) == (0, 0, 0)
