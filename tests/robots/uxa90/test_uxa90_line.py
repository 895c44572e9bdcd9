"""The bus and the sweep on lines good and bad; the time between them is the test's."""

import heapq
from itertools import count

import pytest

from lbr.drivers.serial_line import SerialLine
from lbr.robots.uxa90.driver import packets
from lbr.robots.uxa90.driver.bus import Bus
from lbr.robots.uxa90.driver.frames import TAKE_CONTROL, Frame
from lbr.robots.uxa90.driver.messages import InquireCommand
from lbr.robots.uxa90.driver.plausibility import TOLERANCE
from lbr.robots.uxa90.driver.poller import Poller
from lbr.robots.uxa90.driver.requests import inquiry
from tests.fuzzing.uxa90_answers import KINDS, Fuzzer, wrong

BYTE_S = 10 / 115_200


class FuzzLine(SerialLine):
    """A line to emulated servos; waiting is what moves the clock."""

    def __init__(self, fuzzer):
        self.fuzzer, self.now, self.baud = fuzzer, 100.0, 115_200
        self.written = []
        self._due, self._order = [], count()

    def send(self, data):
        self.written.append(data)
        after = self.now
        for delay_s, piece in self.fuzzer.feed(data):
            after += 6 * BYTE_S
            heapq.heappush(self._due, (after + delay_s, next(self._order), piece))
        return True

    def inject(self, piece, delay_s=0.0):
        heapq.heappush(self._due, (self.now + delay_s, next(self._order), piece))

    def read(self, wait_s):
        until = self.now + max(wait_s, 1e-5)
        if self._due and self._due[0][0] <= until:
            self.now = max(self.now, self._due[0][0])
            came = b""
            while self._due and self._due[0][0] <= self.now:
                came += heapq.heappop(self._due)[2]
            return came
        self.now = until
        return b""

    def close(self):
        pass


class Rig:
    def __init__(self, policy="plausible", together=5, moving=False, **fuzz):
        self.fuzzer = Fuzzer(**fuzz)
        self.line = FuzzLine(self.fuzzer)
        self.bus = Bus(self.line, 0.03, clock=lambda: self.line.now)
        self.told = []
        self.poller = Poller(
            self.fuzzer.servos, lambda: self.line.now, 0.05, policy, together,
            moving=lambda _servo: moving, tell=lambda *event: self.told.append(event),
        )  # fmt: skip
        self.poller.reading = True
        self.wrong = []

    def run(self, seconds):
        until = self.line.now + seconds
        while self.line.now < until:
            self.line.now += self.poller.turn(self.bus)
            self.wrong += wrong(self.believed(), self.fuzzer.truth, TOLERANCE)

    def believed(self):
        return {servo: seen.position for servo, seen in self.poller.seen.items() if seen.trusted}


@pytest.mark.parametrize("together", [1, 5, 25])
def test_on_a_good_line_everything_is_read_and_believed(together):
    rig = Rig(together=together, share=0.0)
    rig.run(0.6)
    assert rig.believed() == rig.fuzzer.truth
    rig.run(1.5)
    assert rig.poller.sweeps_hz > (19.0 if together > 1 else 15.0)
    counts = rig.bus.counts
    assert (counts.timeouts, counts.babble, counts.doubted) == (0, 0, 0)


@pytest.mark.parametrize("kind", KINDS)
def test_on_a_bad_line_nothing_is_believed_of_another_servo(kind):
    rig = Rig(kinds=(kind,), share=0.0, seed=3)
    rig.run(0.6)
    rig.fuzzer.share = 0.03
    rig.run(20.0)
    assert rig.fuzzer.spoilt > 15
    assert rig.wrong == []


def test_thousands_of_bytes_of_all_that_is_wrong_crash_nothing_and_are_believed_of_nobody():
    rig = Rig(share=0.04, seed=7)
    rig.run(60.0)
    assert rig.fuzzer.spoilt_bytes > 2000
    assert rig.wrong == []
    rig.fuzzer.share = 0.0
    rig.run(14.0)
    assert rig.believed() == rig.fuzzer.truth


@pytest.mark.parametrize("late_s", [0.05, 0.16, 0.31, 0.47, 0.7])
def test_answers_that_always_come_late_are_believed_of_nobody(late_s):
    rig = Rig(share=0.0, reply_s=late_s)
    rig.run(20.0)
    assert rig.wrong == []


def test_noise_between_questions_disturbs_only_for_a_moment():
    rig = Rig(share=0.0)
    rig.run(1.0)
    rig.line.inject(b"\x07\x20\x33")
    rig.run(0.5)
    assert rig.bus.counts.babble == 3
    assert rig.believed() == rig.fuzzer.truth
    assert rig.bus.quiet()


def test_a_silent_servo_is_named_and_slows_nobody_for_long():
    rig = Rig(share=0.0)
    place = dict(rig.fuzzer.truth)
    rig.fuzzer.truth = {servo: at for servo, at in place.items() if servo != 7}
    rig.run(8.0)
    assert rig.poller.seen[7].reason == "does not answer"
    assert rig.believed() == rig.fuzzer.truth
    rig.run(4.0)
    assert rig.poller.sweeps_hz > 15.0
    rig.fuzzer.truth = place
    rig.run(10.0)
    assert rig.believed() == place


class OneByOne(Fuzzer):
    """Hears only the first of several questions in one write."""

    def feed(self, data):
        return super().feed(data[:4])


def test_servos_that_hear_only_one_question_in_a_write_are_asked_singly():
    rig = Rig(share=0.0)
    rig.line.fuzzer = OneByOne(share=0.0)
    rig.fuzzer = rig.line.fuzzer
    rig.run(12.0)
    assert [kind for kind, _, _ in rig.told] == ["one_by_one"]
    assert rig.believed() == rig.fuzzer.truth


def test_moves_are_written_whatever_the_line_does_and_their_answers_are_nobodys_then():
    rig = Rig(share=0.0)
    rig.run(0.6)
    rig.line.inject(b"\x01\x02\x03")
    rig.bus.drain()
    rig.line.read(0.001)
    rig.line.inject(b"\x01")
    assert not rig.bus.quiet() or rig.bus.write([(3, packets.move(3, 0, 100))]) is None
    rig.bus.write([(3, packets.move(3, 0, 100))])
    assert rig.line.written[-1] == bytes.fromhex("FF036467")
    rig.run(0.5)
    assert rig.wrong == []


def test_a_frame_that_comes_between_is_told_and_takes_nobodys_place():
    rig = Rig(share=0.0)
    rig.run(0.6)
    strays = rig.bus.counts.babble
    rig.line.inject(TAKE_CONTROL, 0.002)
    rig.run(0.3)
    assert list(rig.bus.board_frames) == [Frame(0x10, 0, b"\x01")]
    assert rig.bus.counts.babble == strays
    assert rig.believed() == rig.fuzzer.truth


def test_what_is_never_answered_is_given_up_and_counted():
    rig = Rig(share=0.0)
    assert rig.bus.ask(packets.ask(packets.REGISTERS["boundary"], 30), 2, 0.1) is None
    assert rig.bus.counts.timeouts == 1


@pytest.mark.parametrize("disturbed", [False, True])
def test_a_silent_main_board_that_is_asked_keeps_no_move_waiting(disturbed):
    rig = Rig()
    rig.bus = Bus(rig.line, 0.03, clock=lambda: rig.line.now, write_waits=lambda: True)
    if disturbed:
        rig.line.inject(b"\x01")
        rig.bus.quiet()
    begun = rig.line.now
    assert inquiry(InquireCommand(what="firmware"), ())(rig.bus).reason
    assert rig.bus.ask(packets.read(3), 2, 0.1) is None or not disturbed
    assert rig.line.now - begun < 0.05
