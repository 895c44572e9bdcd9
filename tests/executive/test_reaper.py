"""What ends processes that the executive has left behind, frozen, hanging or in hiding as they may be."""

import ctypes
import fcntl
import os
import signal
import subprocess
import sys
import time
from contextlib import closing, suppress
from math import inf
from pathlib import Path

import pytest

from lbr.bus.stamp import Origin
from lbr.capability import lifeline
from lbr.database.rows import ExternalCommandRow
from lbr.executive.processes import external
from lbr.executive.processes.external import ExternalCommands
from lbr.executive.processes.reap import Silence, Thread
from lbr.executive.processes.reaper import Reaper
from tests.support import programs
from tests.support.waiting import HANG_S, until

EXECUTIVE = """
import os, signal, sys
from subprocess import Popen
from lbr.executive.processes.reaper import Reaper
reaper = Reaper()
mark = reaper.mark()
child = Popen(["/bin/sh", "-c", sys.argv[1]], env=os.environ | mark.environment, start_new_session=True)
(mark.guards if "guarded" in sys.argv else mark.began)(child.pid)
print(reaper._popen.pid, flush=True)
signal.pause()
"""
"""An executive that has started one process, by a line for the shell."""
PIDS = "echo $$ >> pids; exec sleep 60"
PR_SET_CHILD_SUBREAPER = 36


@pytest.fixture(autouse=True)
def adopt():
    """Have what is orphaned come to this process, so that every end is seen and buried."""
    libc = ctypes.CDLL(None)
    libc.prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    yield
    libc.prctl(PR_SET_CHILD_SUBREAPER, 0, 0, 0, 0)


@pytest.fixture
def executive(tmp_path, monkeypatch):
    """Start one; return it, its reaper's pid, and the pids of what it has started, this many."""
    monkeypatch.chdir(tmp_path)
    started, reapers = [], []

    def start(line: str, many: int, *more: str) -> tuple["subprocess.Popen[str]", int, list[int]]:
        command = [sys.executable, "-c", EXECUTIVE, line, *more]
        popen = programs.start(command, stdout=subprocess.PIPE, text=True, env=os.environ | SPEAKS)
        started.append(popen)
        assert popen.stdout is not None
        with popen.stdout as said:
            reaper = int(said.readline())
        reapers.append(reaper)
        return popen, reaper, until(lambda: len(found := pids(tmp_path)) == many and found)

    yield start
    for popen in started:
        popen.kill()
        popen.wait()
    for pid in (*reapers, *pids(tmp_path)):
        if lives(pid):
            os.kill(pid, signal.SIGKILL)


def pids(home: Path) -> list[int]:
    try:
        return [int(line) for line in (home / "pids").read_text().splitlines()]
    except FileNotFoundError:
        return []


def lives(pid: int) -> bool:
    with suppress(ChildProcessError):
        os.waitpid(pid, os.WNOHANG)
    return Path(f"/proc/{pid}").exists()


def kill(popen: "subprocess.Popen[str]") -> float:
    popen.kill()
    popen.wait()
    return time.monotonic()


@pytest.mark.parametrize(
    "line",
    [
        f"trap '' TERM HUP; {PIDS}",
        f"(setsid sh -c 'trap \"\" TERM HUP; {PIDS}' &); sleep 60",
        f"(env -i PATH=$PATH sh -c '{PIDS}' &); sleep 60",
        f"(setsid sh -c '(setsid sh -c \"{PIDS}\" &); {PIDS}' &)",
    ],
    ids=["deaf", "deaf in a session of its own", "with nothing in its environment", "two of whom the first has ended"],
)
@pytest.mark.parametrize("frozen", ["the process", "the reaper", "both", "none"])
def test_nothing_is_left_two_seconds_after_the_executive_is_killed(executive, line, frozen):
    popen, reaper, found = executive(line, 2 if "two" in line or line.count("setsid") > 1 else 1)
    for pid in {"the process": found, "the reaper": [reaper], "both": [*found, reaper], "none": []}[frozen]:
        os.kill(pid, signal.SIGSTOP)
    kill(popen)
    until(lambda: not any(map(lives, [*found, reaper])), what="nothing is left")


def test_what_forks_and_leaves_faster_than_it_is_looked_at_is_ended_too(executive, tmp_path):
    (tmp_path / "fleeing.py").write_text(
        "import fcntl\n"
        "from os import _exit, fork, getpid\n"
        "held = open('held', 'w')\n"
        "fcntl.flock(held, fcntl.LOCK_EX)\n"
        "print(getpid(), file=open('pids', 'a'), flush=True)\n"
        "while True:\n"
        "    if fork():\n"
        "        _exit(0)\n"
    )
    popen, _, (group,) = executive(f"exec {sys.executable} -I -S fleeing.py", 1)
    try:
        kill(popen)
        with (tmp_path / "held").open() as held:
            until(lambda: is_free(held.fileno()), what="no process holds it")
    finally:
        with suppress(ProcessLookupError):
            os.killpg(group, signal.SIGKILL)


def is_free(fd: int) -> bool:
    with suppress(BlockingIOError):
        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return True
    return False


GUARD = f'{sys.executable} -I -S -c \'import os; os.getpgrp() == os.getpid() or os.setpgid(0, 0); os.execlp(*["sh"] * 2, "-c", os.environ["LINE"])\''
LINE = Origin("ann", 0.0)
SPEAKS = {"LINE": "trap '' HUP; echo $$ >> pids; kill -STOP $$; : > spoken; exec sleep 60"}
"""A guard has a group of its own in its driver's session."""


def test_a_process_that_a_driver_joins_later_is_told_as_one_with_a_guard():
    child = programs.start([sys.executable, "-c", "import time; time.sleep(60)"])
    try:
        with closing(Reaper()) as reaper:
            mark = reaper.mark()
            mark.began(child.pid)
            assert [word[0] for word in reaper.known.values()] == ["+"]
            mark.guards(child.pid)
            assert [word[0] for word in reaper.known.values()] == ["*"]
    finally:
        child.kill()
        child.wait()


def test_a_drivers_guard_is_not_killed_but_continued_until_its_time_is_over(executive):
    line = f"{lifeline.LAST_WORD}=2 {GUARD} & exec sleep 60"
    popen, reaper, (guard,) = executive(line, 1, "guarded")
    until(lambda: frozen(guard))
    killed = kill(popen)
    until(Path("spoken").exists)
    assert lives(guard)
    until(lambda: not lives(guard) and not lives(reaper))
    assert time.monotonic() - killed >= 2.0


@pytest.mark.parametrize("more", [(), ("guarded",)], ids=["of a program", "beside a driver, in another session"])
def test_what_only_says_that_it_is_a_guard_is_not_spared(executive, more):
    line = f"{lifeline.LAST_WORD}=60 setsid {GUARD} & exec sleep 60"
    popen, _, (guard,) = executive(line, 1, *more)
    kill(popen)
    until(lambda: not lives(guard), what="it is ended")


def test_a_program_with_a_guards_word_in_its_own_session_is_not_spared(executive):
    popen, _, (guard,) = executive(f"{lifeline.LAST_WORD}=60 {GUARD} & exec sleep 60", 1)
    kill(popen)
    until(lambda: not lives(guard), what="it is ended")


def test_a_reaper_that_is_replaced_spares_the_guard_of_a_driver_that_has_ended(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = f"{lifeline.LAST_WORD}=60 {GUARD} & exec sleep 60"
    with closing(Reaper()) as reaper:
        mark = reaper.mark()
        driver = programs.start(
            ["/bin/sh", "-c", line], env=os.environ | SPEAKS | mark.environment, start_new_session=True
        )
        mark.guards(driver.pid)
        (guard,) = until(lambda: pids(tmp_path))
        driver.kill()
        driver.wait()
        mark.ended()
        first = reaper._popen.pid
        os.kill(first, signal.SIGKILL)
        until(lambda: reaper.step() == "" and reaper._popen.pid != first)
        second = reaper._popen
    try:
        until(Path("spoken").exists)
        assert lives(guard)
        assert second.poll() is None
    finally:
        os.kill(guard, signal.SIGKILL)
        second.wait(HANG_S)


def frozen(pid: int) -> bool:
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "T"


HANGS = """
import ctypes, os, sys, time
from subprocess import Popen
from lbr.executive.processes.reaper import Reaper
reaper = Reaper(hangs_s=float(sys.argv[2]))
mark = reaper.mark()
child = Popen(["/bin/sh", "-c", sys.argv[1]], env=os.environ | mark.environment, start_new_session=True)
mark.began(child.pid)
reaper.beat()
print(reaper._popen.pid, flush=True)
exec(sys.argv[3])
"""


FREEZES = "os.kill(os.getpid(), 19); time.sleep(60)"
FREEZES_BOTH = (
    """
end = time.monotonic() + 5.0
while time.monotonic() < end and not open(f"/proc/{reaper._popen.pid}/timers").read():
    time.sleep(0.01)
os.kill(reaper._popen.pid, 19)
"""
    + FREEZES
)


@pytest.mark.parametrize(
    "hangs",
    ["ctypes.PyDLL(None).sleep(60)", "while True: pass", FREEZES, FREEZES_BOTH],
    ids=["holds the interpreter's lock", "turns in circles", "is frozen", "is frozen after its reaper"],
)
def test_an_executive_that_hangs_is_ended_with_all_that_it_has_started(tmp_path, monkeypatch, hangs):
    monkeypatch.chdir(tmp_path)
    command = [sys.executable, "-c", HANGS, PIDS, "2.5", hangs]
    popen = programs.start(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    (pid,) = until(lambda: pids(tmp_path))
    _, said = popen.communicate(timeout=60.0)
    assert popen.returncode == -signal.SIGKILL
    assert "which runs the robot, stood still for 2.5 s: killed" in said
    until(lambda: not lives(pid))


def test_an_executive_that_beats_or_rests_is_not_ended(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    lives_on = (
        "for _ in range(5):\n    reaper.beat()\n    time.sleep(0.5)\nreaper.rest()\ntime.sleep(3.0)\nprint('lived')\n"
    )
    command = [sys.executable, "-c", HANGS, PIDS, "1.0", lives_on]
    popen = programs.start(command, stdout=subprocess.PIPE, text=True)
    out, _ = popen.communicate(timeout=60.0)
    assert "lived" in out


class Watched:
    """An executive's silence, with a clock and threads of our own; 1 is the main thread, 2 another."""

    def __init__(self) -> None:
        self.silence = Silence(10.0)
        self.silence.beat(0.0)
        self.threads = {1: Thread(0.0, 0.0, "S"), 2: Thread(0.0, 0.0, "S")}

    def until_it_hangs(self, most_s: float = 200.0, **had: Thread) -> float:
        """Return how long it took, looked at twice a second; `had` is what a thread gets in a second."""
        at = 0.0
        while at < most_s:
            at += 0.5
            for name, one in had.items():
                number = int(name.strip("_"))
                self.threads[number] = Thread(one.ran * at, one.waited * at, one.state)
            if self.silence.hangs(at, lambda: dict(self.threads), 1):
                return at
        return inf


@pytest.mark.parametrize(
    ("had", "within"),
    [
        ({}, (10.0, 11.5)),
        ({"_1": Thread(1.0, 0.0, "R")}, (10.0, 11.5)),
        ({"_1": Thread(0.0, 0.0, "T")}, (10.0, 11.5)),
        ({"_1": Thread(0.5, 0.5, "R")}, (16.0, 20.0)),
        ({"_2": Thread(0.5, 0.5, "R")}, (16.0, 20.0)),
        ({"_2": Thread(0.0, 1.0, "R")}, (20.0, 21.5)),
        ({"_1": Thread(0.0, 1.0, "R")}, (inf, inf)),
        ({"_1": Thread(0.0, 0.0, "D")}, (inf, inf)),
        ({"_1": Thread(0.0, 0.0, "t")}, (inf, inf)),
    ],
)
def test_a_silence_is_judged_by_the_time_that_the_machine_gave(had, within):
    least, most = within
    assert least <= Watched().until_it_hangs(**had) <= most


def test_a_beat_begins_the_count_again_and_a_pause_of_the_reaper_is_not_counted():
    one = Watched()
    for at in range(1, 100):
        assert not one.silence.hangs(at * 0.5, lambda: one.threads, 1) or at * 0.5 > 10.0
        if at % 12 == 0:
            one.silence.beat(at * 0.5)
    late = Watched()
    assert not late.silence.hangs(3600.0, lambda: late.threads, 1)
    assert not late.silence.hangs(7200.0, lambda: late.threads, 1)


def test_a_reaper_that_dies_is_replaced_and_knows_what_runs(tmp_path):
    with closing(Reaper()) as reaper:
        mark = reaper.mark()
        started = programs.start(["/bin/sleep", "60"], start_new_session=True)  # by its session alone
        mark.began(started.pid)
        first = reaper._popen.pid
        os.kill(first, signal.SIGKILL)
        until(lambda: reaper.step() == "" and reaper._popen.pid != first)
    assert started.wait(HANG_S) == -signal.SIGKILL


def test_what_a_process_has_left_behind_ends_with_it_while_the_run_goes_on(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with closing(Reaper()) as reaper:
        line = f"(setsid sh -c '{PIDS}' &); exec sleep 60"
        running = []
        for many in (1, 2):
            mark = reaper.mark()
            popen = programs.start(["/bin/sh", "-c", line], env=os.environ | mark.environment, start_new_session=True)
            running.append(popen)
            mark.began(popen.pid)
            until(lambda: len(pids(tmp_path)) == many)  # noqa: B023 - it is called at once
            if many == 1:
                popen.kill()
                popen.wait()
                mark.ended()
        first, second = pids(tmp_path)
        until(lambda: not lives(first))
        assert lives(second)
    assert running[1].wait(HANG_S) == -signal.SIGKILL
    until(lambda: not lives(second))


def test_what_a_stopped_command_has_started_ends_with_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = f"(setsid sh -c '{PIDS}' &); exec sleep 60"
    row = ExternalCommandRow(name="probe", argv=("/bin/sh", "-c", line), blocking=False)
    with closing(Reaper()) as reaper, closing(ExternalCommands(tmp_path, "lbr", reaper)) as commands:
        commands.start(row, (), LINE, 0.0)
        (pid,) = until(lambda: pids(tmp_path))
        assert "has ended" in commands.stop("probe")
        until(lambda: not lives(pid))


def test_frozen_commands_hold_up_the_end_of_the_robot_once_and_not_one_after_the_other(tmp_path, monkeypatch):
    monkeypatch.setattr(external, "CLOSE_S", 2.0)
    with closing(Reaper()) as reaper:
        commands = ExternalCommands(tmp_path, "lbr", reaper)
        for number in range(5):
            row = ExternalCommandRow(name=f"probe{number}", argv=("/bin/sleep", "60"), blocking=False)
            os.kill(commands.start(row, (), LINE, 0.0).pid, signal.SIGSTOP)
        began = time.monotonic()
        commands.close()
        assert time.monotonic() - began < 5 * external.CLOSE_S


def test_a_process_that_was_frozen_goes_on_when_its_pipe_hangs_up():
    theirs, ours = os.pipe()
    popen = programs.start(["/bin/cat"], stdin=theirs)
    lifeline.wake(theirs, popen.pid)
    os.close(theirs)
    popen.send_signal(signal.SIGSTOP)
    assert os.waitid(os.P_PID, popen.pid, os.WSTOPPED) is not None
    os.close(ours)
    assert popen.wait(HANG_S) == 0


def test_a_reaper_that_is_frozen_anew_after_the_end_of_the_executive_goes_on(executive):
    popen, reaper, (pid,) = executive(PIDS, 1)
    until(lambda: timers(reaper) == 1)
    popen.kill()
    os.kill(pid, signal.SIGSTOP)
    until(lambda: timers(reaper) == 2 or not lives(pid))  # it may be done already
    os.kill(reaper, signal.SIGSTOP)
    until(lambda: not lives(pid))


def timers(pid: int) -> int:
    """Return how many timers a process has."""
    return Path(f"/proc/{pid}/timers").read_text().count("notify:")


def test_a_tethered_process_dies_with_its_parent_also_when_it_is_frozen(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = "import sys; from subprocess import run; from lbr.capability.die_with_parent import dying_with_parent; run(dying_with_parent(('/bin/sh', '-c', sys.argv[1])))"
    parent = programs.start([sys.executable, "-c", line, PIDS])
    (pid,) = until(lambda: pids(tmp_path))
    os.kill(pid, signal.SIGSTOP)
    parent.kill()
    parent.wait()
    until(lambda: not lives(pid))
