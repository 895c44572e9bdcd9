"""What every guard does beside its stop: how often it is told of its driver, who waits for it, how long it goes on."""

import gc
import os
import runpy
import subprocess
import sys
import termios
from pathlib import Path
from types import SimpleNamespace

import pytest

from lbr.drivers.guard import BEAT_S, DEAF_S, RESTING_BEAT_S, STARTS_S, Guard
from lbr.drivers.servos.guard_release import STEP_S
from lbr.drivers.wheels import guard_stop
from tests.support import programs
from tests.support.waiting import until

RELEASING = """
import sys
from lbr.drivers.servos import guard_release

class Servos:
    blind, least_hold_s = sys.argv[-1] == "blind", {least_hold_s}

    def __init__(self, line, servos, words):
        print("servos", line, servos, list(words))

    def hold(self):
        print("hold")
        return True

    def keep(self):
        print("keep")

    def prepare(self):
        print("prepare")
        return 0.0

    def fade(self, strength):
        print("fade")

    def off(self):
        print("off")

guard_release.drop_output = lambda line: print("drop", line)
guard_release.run(sys.argv[1:], Servos)
"""


def test_a_guard_of_wheels_watches_soon_as_it_imports_nothing_else_of_the_project():
    watched, told = os.pipe()
    os.write(told, b"q")
    words = ("-I", "-S", "-X", "importtime", guard_stop.__file__, "-1", str(watched), "-1", "120", "00", "-")
    done = programs.run([sys.executable, *words], pass_fds=(watched,), capture_output=True, text=True, check=True)
    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert "watch" in imported
    assert not {one for one in imported if one.startswith("lbr")}
    os.close(watched)
    os.close(told)


def test_a_guard_is_told_often_that_something_may_move_and_seldom_that_nothing_does():
    now, told = [100.0], []
    guard = Guard(lambda pipe, _driver: told.append(os.dup(pipe)) or ["-c", "input()"], (), lambda: now[0], 1.0)
    (pipe,) = told
    counts = []
    for turning in (False, True):
        guard.beat(turning=turning)
        os.read(pipe, 4096)
        for _ in range(2000):
            now[0] += 0.001
            guard.beat(turning=turning)
        counts.append(len(os.read(pipe, 4096)))
    guard.dismiss()
    os.close(pipe)
    assert counts == [pytest.approx(2.0 / RESTING_BEAT_S, abs=1.0), pytest.approx(2.0 / BEAT_S, abs=10.0)]


@pytest.fixture
def starting():
    """A guard whose program hears its driver once a byte is written; on a clock of the test."""
    begin, starts = os.pipe()
    now = [100.0]
    hears = f"import os, sys; os.read({begin}, 1); os.read(int(sys.argv[1]), 99); os.read({begin}, 1)"
    guard = Guard(lambda pipe, _driver: ["-c", hears, str(pipe)], (begin,), lambda: now[0], 1.0)
    os.close(begin)
    yield guard, now, starts
    os.close(starts)
    guard.dismiss()


def test_a_guard_that_takes_seconds_to_start_stands_and_listens_once_it_has_heard_its_driver(starting):
    guard, now, starts = starting
    while now[0] < 100.0 + STARTS_S - 0.6:
        now[0] += 0.6
        guard.beat(turning=False)
        assert (guard.standing, guard.listens) == (True, False)
    os.write(starts, b"1")
    until(lambda: guard.listens)
    assert guard.standing


@pytest.mark.parametrize(("turning", "patience_s"), [(False, STARTS_S), (True, DEAF_S)])
def test_a_guard_that_does_not_start_or_hangs_stands_no_more_the_sooner_while_something_may_move(
    starting, turning, patience_s
):
    guard, now, _starts = starting
    guard.beat(turning=turning)
    for share, stands in ((0.9, True), (1.1, False)):
        now[0] = 100.0 + share * patience_s + RESTING_BEAT_S * (not turning)
        guard.beat(turning=turning)
        assert guard.standing is stands


def test_guards_that_are_left_the_line_go_on_and_are_waited_for_by_the_next():
    begun, goes_on = os.pipe()
    program = ["-c", f"import os; os.read({begun}, 1)"]
    guards = [Guard(lambda *_: program, (begun,), lambda: 0.0, 1.0) for _ in range(3)]
    first, second, third = (guard.pid for guard in guards)
    for _ in range(2):
        guards.pop(0).leave()
        gc.collect()  # a process that nobody keeps would be told as lost
    os.close(goes_on)
    os.close(begun)
    until(lambda: (state(first), state(second)) == ("Z", "Z"), "they end when they are done")
    guards.pop().leave()
    assert (state(first), state(second)) == ("", "")
    until(lambda: state(third) == "Z", "so does the last one")


def state(pid):
    """The letter of a process, nothing if there is none."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except FileNotFoundError:
        return ""


def test_who_only_reads_the_program_of_a_guard_runs_nothing_and_finds_its_modules_as_before():
    before = list(sys.path)
    assert runpy.run_path(guard_stop.__file__, run_name="read")["TRIES"] == guard_stop.TRIES
    assert sys.path == before


def test_a_controller_that_says_nothing_is_told_to_stop_ten_times_in_a_third_of_a_second(monkeypatch):
    now, told, dropped = [100.0], [], []

    def nothing_comes(_reads, _writes, _errors, seconds):
        now[0] += seconds
        return [], [], []

    def write(_line, stop):
        told.append((now[0], stop))

    monkeypatch.setattr(guard_stop, "outlast", lambda *_: True)
    monkeypatch.setattr(guard_stop, "time", SimpleNamespace(monotonic=lambda: now[0]))
    monkeypatch.setattr(guard_stop, "select", SimpleNamespace(select=nothing_comes))
    monkeypatch.setattr(guard_stop, "os", SimpleNamespace(write=write))
    monkeypatch.setattr(guard_stop.termios, "tcflush", lambda _line, queue: dropped.append((now[0], queue)))
    with Path(os.devnull).open() as line:
        guard_stop.main(line.fileno(), -1, -1, 150, b"stop\r", b"ok\r")
    assert told == [(pytest.approx(100.0 + 0.03 * tried), b"stop\r") for tried in range(10)]
    assert now[0] == pytest.approx(100.3)
    assert dropped[-1] == (now[0], termios.TCOFLUSH), "closing a line waits for what is left in it"


@pytest.mark.parametrize(
    ("said", "blind", "acts"),
    [("m", False, True), ("m", True, True), ("z", False, True), ("z", True, False), ("q", False, False)],
)
def test_a_guard_of_servos_acts_unless_it_is_dismissed_or_cannot_ask_whether_one_has_torque(line, said, blind, acts):
    told = released(line, said, *(["blind"] if blind else []))
    assert told[0] == f"servos {line} [1, 2] {['blind'] if blind else []}"
    assert list(dict.fromkeys(told[1:])) == (["hold", "keep", "prepare", "fade", "off", f"drop {line}"] if acts else [])


@pytest.mark.parametrize(("hold_s", "least_hold_s"), [(2 * STEP_S, 0.0), (0.0, 2 * STEP_S)])
def test_a_guard_of_servos_holds_as_long_as_its_row_says_and_at_least_as_long_as_they_need(line, hold_s, least_hold_s):
    assert "keep" in released(line, "m", hold_s=hold_s, least_hold_s=least_hold_s)


def released(line, said, *more, hold_s=2 * STEP_S, least_hold_s=0.0):
    """What servos are told by their guard after a driver that said this last."""
    pipe, alive = os.pipe()
    driver = os.pidfd_open(os.getpid())
    numbers = (line, pipe, driver, 60_000, -1, "-", hold_s, STEP_S, "1,2", *more)
    argv = [sys.executable, "-c", RELEASING.format(least_hold_s=least_hold_s), *map(str, numbers)]
    guard = programs.start(argv, pass_fds=(line, pipe, driver), stdout=subprocess.PIPE, text=True)
    os.write(alive, said.encode())
    for fd in (pipe, alive, driver):
        os.close(fd)
    told, _ = guard.communicate()
    assert guard.returncode == 0
    return told.splitlines()
