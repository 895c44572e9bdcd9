"""What every guard does beside its stop: how often it is told of its driver, who waits for it, how long it goes on."""

import gc
import os
import runpy
import signal
import subprocess
import sys
import termios
from pathlib import Path
from types import SimpleNamespace

import pytest

from lbr.drivers.guard import Guard
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
    lives, ends = os.pipe()

    def command(pipe, _driver):
        told.append(os.dup(pipe))
        return ["-c", f"import os; os.read({lives}, 1)"]

    guard = Guard(command, (lives,), lambda: now[0], 1.0)
    os.close(lives)
    (pipe,) = told
    assert not os.get_blocking(guard._alive), "a full pipe holds no driver up"
    counts = []
    for turning, beat in ((False, b"z"), (True, b"m")):
        guard.beat(turning=turning)
        os.read(pipe, 4096)
        for _ in range(2000):
            now[0] += 0.001
            guard.beat(turning=turning)
        said = os.read(pipe, 4096)
        assert said.replace(beat, b"") == b""
        counts.append(len(said))
        now[0] += 0.5
        guard.beat(turning=turning)
        assert guard.standing, "it has read what it was told"
        os.read(pipe, 4096)
    os.close(ends)
    guard.dismiss()
    assert os.read(pipe, 4096) == b"q"
    os.close(pipe)
    assert counts == [pytest.approx(2.0 / 0.5, abs=1.0), pytest.approx(2.0 / 0.015, abs=10.0)]


def test_a_guard_leaves_no_descriptor_behind_also_if_it_cannot_begin(monkeypatch):
    def begins(*fds):
        return Guard(lambda *_: ["-c", ""], fds, lambda: 0.0, 1.0)

    def no_process(_pid):
        raise OSError("no process")

    before = len([*Path("/proc/self/fd").iterdir()])
    begins().dismiss()
    with pytest.raises(OSError, match="Bad file descriptor"):
        begins(10**6)
    monkeypatch.setattr(os, "pidfd_open", no_process)
    with pytest.raises(OSError, match="no process"):
        begins()
    assert len([*Path("/proc/self/fd").iterdir()]) == before


def test_a_guard_that_does_not_heed_its_dismissal_is_killed():
    guard = Guard(lambda *_: ["-c", "import time; time.sleep(10)"], (), lambda: 0.0, 1.0)
    guard.dismiss()
    assert (guard._process.returncode, guard.standing, guard.woken()) == (-signal.SIGKILL, False, False)


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
    while now[0] < 100.0 + 20.0 - 0.6:
        now[0] += 0.6
        guard.beat(turning=False)
        assert (guard.standing, guard.listens) == (True, False)
    os.write(starts, b"1")
    until(lambda: guard.listens)
    assert guard.standing


@pytest.mark.parametrize(("turning", "patience_s"), [(False, 20.0), (True, 0.4)])
def test_a_guard_that_does_not_start_or_hangs_stands_no_more_the_sooner_while_something_may_move(
    starting, turning, patience_s
):
    guard, now, _starts = starting
    guard.beat(turning=turning)
    for share, stands in ((0.9, True), (1.1, False)):
        now[0] = 100.0 + share * patience_s + 0.5 * (not turning)
        guard.beat(turning=turning)
        assert guard.standing is stands


def test_guards_that_are_left_the_line_go_on_and_are_waited_for_by_the_next():
    begun, goes_on = os.pipe()
    program = f"import os, sys; os.read({begun}, 1); [*iter(lambda: os.read(int(sys.argv[1]), 9), b'')]"
    guards = [Guard(lambda pipe, _: ["-c", program, str(pipe)], (begun,), lambda: 0.0, 1.0) for _ in range(3)]
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


@pytest.mark.parametrize(("answer", "tries"), [(b"", 10), (b"ok\r", 2)])
def test_a_controller_is_told_to_stop_twice_and_ten_times_in_a_third_of_a_second_if_it_says_nothing(
    monkeypatch, answer, tries
):
    now, told, dropped = [100.0], [], []

    def comes(reads, _writes, _errors, seconds):
        now[0] += 0.0 if answer else seconds
        return reads if answer else [], [], []

    def write(_line, stop):
        told.append((now[0], stop))

    monkeypatch.setattr(guard_stop, "outlast", lambda *_: True)
    monkeypatch.setattr(guard_stop, "time", SimpleNamespace(monotonic=lambda: now[0]))
    monkeypatch.setattr(guard_stop, "select", SimpleNamespace(select=comes))
    monkeypatch.setattr(guard_stop, "os", SimpleNamespace(write=write, read=lambda *_: answer))
    monkeypatch.setattr(guard_stop.termios, "tcflush", lambda _line, queue: dropped.append((now[0], queue)))
    with Path(os.devnull).open() as line:
        guard_stop.main(line.fileno(), -1, -1, 150, b"stop\r", b"ok\r")
    waited_s = 0.0 if answer else 0.03
    assert told == [(pytest.approx(100.0 + waited_s * tried), b"stop\r") for tried in range(tries)]
    assert now[0] == pytest.approx(100.0 + waited_s * tries)
    dropped_after = (now[0], termios.TCOFLUSH) in dropped
    assert dropped_after is not bool(answer), "closing a line waits for what is left in it"


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


def test_a_driver_of_servos_that_hangs_while_one_moves_is_killed_after_its_last_words(line):
    words, fd = os.pipe()
    with programs.start(["sleep", "600"]) as driver:
        told = released(line, "m", hangs=driver.pid, last=(fd, b"it hangs"))
    os.close(fd)
    with os.fdopen(words, "rb") as said:
        assert said.read() == b"it hangs"
    assert driver.returncode == -signal.SIGKILL
    assert "off" in told


def released(line, said, *more, hold_s=2 * STEP_S, least_hold_s=0.0, hangs=None, last=(-1, b"")):
    """What servos are told by their guard after a driver that said this last, and then is gone, or hangs."""
    pipe, alive = os.pipe()
    driver = os.pidfd_open(hangs or os.getpid())
    silence_ms = 50 if hangs else 60_000
    numbers = (line, pipe, driver, silence_ms, last[0], last[1].hex() or "-", hold_s, STEP_S, "1,2", *more)
    argv = [sys.executable, "-c", RELEASING.format(least_hold_s=least_hold_s), *map(str, numbers)]
    fds = {line, pipe, driver, last[0]} - {-1}
    guard = programs.start(argv, pass_fds=fds, stdout=subprocess.PIPE, text=True)
    os.write(alive, said.encode())
    for fd in (pipe, driver) if hangs else (pipe, driver, alive):
        os.close(fd)
    told, _ = guard.communicate()
    if hangs:
        os.close(alive)
    assert guard.returncode == 0
    return told.splitlines()
