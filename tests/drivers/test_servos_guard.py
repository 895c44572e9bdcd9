"""What guards are told on their command lines, and how long they may take."""

import termios
from fcntl import ioctl
from itertools import groupby, pairwise
from pathlib import Path
from types import SimpleNamespace

import pytest

from lbr.capability import lifeline
from lbr.drivers.dynamixel import KIND
from lbr.drivers.line_lock import SURE
from lbr.drivers.servos import guard as servos
from lbr.drivers.servos.contract import SlowState
from lbr.drivers.servos.guard_release import STEP_S, GuardRelease
from lbr.drivers.servos.register_release import RegisterRelease
from lbr.drivers.wheels import guard as wheels
from lbr.drivers.wheels.contract import GuardStop
from tests.support.waiting import until

TIOCGEXCL = 0x80045440
"""Whether nobody else may open a terminal; Python's module has no name for it."""


def begun(guard, what):
    """What its process was given."""
    told = Path(f"/proc/{guard.pid}/{what}")
    until(told.read_text, "its program has begun")
    return told.read_text().split("\0")


@pytest.mark.parametrize(("acknowledged", "word"), [(b"ok\r", b"ok\r".hex()), (b"", "-")])
def test_a_guard_of_wheels_knows_line_silence_stop_and_acknowledgement(line, acknowledged, word):
    guard = wheels.Guard(line, GuardStop(b"P 0 0\r", acknowledged), 150, lambda: 0.0)
    told, surroundings = begun(guard, "cmdline"), begun(guard, "environ")
    guard.dismiss()
    assert (told[4], told[7]) == (str(line), "150")
    assert f"{lifeline.LAST_WORD}=2" in surroundings
    assert told[8:10] == [b"P 0 0\r".hex(), word]


@pytest.mark.parametrize("fd", [-1, 0])
def test_a_guard_has_a_last_word_to_write_where_its_driver_reports_to_somebody(line, monkeypatch, fd):
    settings = KIND.parse('{"device": "servos"}')
    monkeypatch.setattr(wheels, "final_report", lambda *_: (fd, b"why"))
    monkeypatch.setattr(servos, "final_report", lambda *_: (fd, b"why" if fd >= 0 else b""))
    guards = (
        wheels.Guard(line, GuardStop(b"P 0 0\r"), 150, lambda: 0.0),
        servos.Guard("lbr.drivers.dynamixel.guard_release", line, settings, [1, 2], lambda: 0.0),
    )
    of_wheels, of_servos = (begun(guard, "cmdline")[:-1] for guard in guards)
    for guard in guards:
        guard.dismiss()
    assert of_wheels[10:] == ([] if fd < 0 else [str(fd), b"why".hex()])
    assert of_servos[7:9] == ([str(fd), "-"] if fd < 0 else [str(fd), b"why".hex()])
    assert of_servos[11:] == ["1,2"]


def test_a_guard_of_servos_may_take_as_long_as_it_holds_fades_and_settles_and_some_more(line):
    settings = KIND.parse('{"device": "servos", "hold_s": 7.0, "release_s": 3.0}')
    guard = servos.Guard("lbr.drivers.dynamixel.guard_release", line, settings, [1, 2], lambda: 0.0, settling_s=2.5)
    surroundings = begun(guard, "environ")
    guard.dismiss()
    (last_word_s,) = (word.partition("=")[2] for word in surroundings if word.startswith(f"{lifeline.LAST_WORD}="))
    assert 12.5 + 5.0 <= int(last_word_s) <= 12.5 + 20.0


class Releasing:
    """Servos of which a guard notes what it tells them, and when."""

    blind, least_hold_s = False, 0.0

    def __init__(self, *, held=True):
        self.now, self.held, self.told = 100.0, held, []

    def clock(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds

    def hold(self):
        self.told.append(("hold", 0.0))
        return self.held

    def keep(self):
        self.told.append(("keep", self.now - 100.0))

    def prepare(self):
        self.told.append(("prepare", self.now - 100.0))
        return 0.5

    def fade(self, strength):
        self.told.append(("fade", strength))

    def off(self):
        self.told.append(("off", self.now - 100.0))

    def of(self, what):
        return [number for name, number in self.told if name == what]


def test_after_its_drivers_death_a_guard_holds_makes_ready_fades_and_releases_each_in_its_time(line):
    servos = Releasing()
    GuardRelease(servos, line, servos.sleep, servos.clock).act(2.0, 2.0)
    names = [name for name, _ in groupby(servos.told, key=lambda one: one[0])]
    assert names == ["hold", "keep", "prepare", "keep", "fade", "off"]
    keeps = servos.of("keep")
    assert (min(keeps), max(keeps)) == (0.0, pytest.approx(2.45, abs=0.051))
    assert all(after - before <= STEP_S + 1e-9 for before, after in pairwise(keeps))
    assert servos.of("prepare") == [pytest.approx(2.0)]
    strengths = servos.of("fade")
    assert strengths[0] == 1.0
    assert strengths == sorted(strengths, reverse=True)
    assert 0.0 < strengths[-1] <= 0.051
    assert servos.of("off") == pytest.approx([4.5 + STEP_S * again for again in range(SURE)])


def test_where_nothing_has_torque_a_guard_has_no_more_to_do_and_another_may_open_the_line(line):
    ioctl(line, termios.TIOCEXCL)
    servos = Releasing(held=False)
    GuardRelease(servos, line, servos.sleep, servos.clock).act(2.0, 1.0)
    assert servos.told == [("hold", 0.0)]
    assert ioctl(line, TIOCGEXCL, bytes(4)) == bytes(4)


class RegisterBus:
    """Servos whose registers can be read: which have torque, and which do not answer."""

    def __init__(self, *on, silent=()):
        self.on, self.silent, self.wrote = set(on), set(silent), []

    def read_state(self, servo, _patience_s):
        if servo in self.silent:
            return None
        motion = SimpleNamespace(position=500 + servo, speed=0)
        return motion, SlowState(0.0, servo in self.on, 512, 100, 400, 12.0, 30.0)

    def drain(self):
        self.wrote.append(("drain",))

    def write_positions(self, goals):
        self.wrote.append(("positions", goals))

    def write_limits(self, limits):
        self.wrote.append(("limits", limits))

    def torque_off(self, servos):
        self.wrote.append(("off", list(servos)))


MODEL = SimpleNamespace(holding_goal=lambda position, _speed, _goal: position)


def test_a_guard_holds_each_servo_that_has_torque_where_it_is_and_those_that_answer_later_then():
    bus = RegisterBus(1, 2, silent={2})
    servos = RegisterRelease(bus, MODEL, [1, 2, 3])
    assert servos.hold()
    assert bus.wrote == [("drain",), ("positions", {1: 501})]
    bus.silent.clear()
    servos.keep()
    assert bus.wrote[2:] == [("drain",), ("positions", {2: 502})]
    servos.fade(0.5)
    servos.fade(0.0001)
    assert bus.wrote[4:] == [("limits", {1: 200, 2: 200}), ("limits", {1: 1, 2: 1})]
    servos.off()
    assert bus.wrote[-1] == ("off", [1, 2, 3])


@pytest.mark.parametrize(("on", "silent", "held"), [((), (), False), ((), (3,), True), ((2,), (), True)])
def test_a_guard_holds_as_long_as_a_servo_may_have_torque(on, silent, held):
    assert RegisterRelease(RegisterBus(*on, silent=silent), MODEL, [1, 2, 3]).hold() is held
