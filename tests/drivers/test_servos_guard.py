"""What guards are told on their command lines, and how long they may take."""

import os
from pathlib import Path

import pytest

from lbr.capability import lifeline
from lbr.drivers.dynamixel import KIND
from lbr.drivers.servos import guard as servos
from lbr.drivers.wheels import guard as wheels
from lbr.drivers.wheels.contract import GuardStop
from tests.support.waiting import until


@pytest.fixture
def line():
    near, far = os.openpty()
    yield far
    os.close(near)
    os.close(far)


def begun(guard, what):
    """What its process was given."""
    told = Path(f"/proc/{guard.pid}/{what}")
    until(told.read_text, "its program has begun")
    return told.read_text().split("\0")


@pytest.mark.parametrize(("acknowledged", "word"), [(b"ok\r", b"ok\r".hex()), (b"", "-")])
def test_a_guard_of_wheels_knows_line_silence_stop_and_acknowledgement(line, acknowledged, word):
    guard = wheels.Guard(line, GuardStop(b"P 0 0\r", acknowledged), 150, lambda: 0.0)
    told = begun(guard, "cmdline")
    guard.dismiss()
    assert (told[4], told[7]) == (str(line), "150")
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
