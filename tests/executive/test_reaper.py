"""What ends processes that the executive has left behind, frozen, hanging or in hiding as they may be."""

import ctypes
import fcntl
import os
import signal
import subprocess
import sys
import time
from contextlib import closing, suppress
from pathlib import Path

import pytest

from lbr.capability import lifeline
from lbr.database.rows import ExternalCommandRow
from lbr.executive.processes.external import ExternalCommands
from lbr.executive.processes.reaper import Reaper
from tests.support import programs
from tests.support.robot import until

EXECUTIVE = """
import os, signal, sys
from subprocess import Popen
from lbr.executive.processes.reaper import Reaper
reaper = Reaper()
mark = reaper.mark()
child = Popen(["/bin/sh", "-c", sys.argv[1]], env=os.environ | mark.environment, start_new_session=True)
mark.began(child.pid)
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
    """Start one; return it, its reaper's pid, and the pids of what it has started, so many."""
    monkeypatch.chdir(tmp_path)
    started, reapers = [], []

    def start(line: str, many: int) -> tuple["subprocess.Popen[str]", int, list[int]]:
        command = [sys.executable, "-c", EXECUTIVE, line]
        popen = programs.start(command, stdout=subprocess.PIPE, text=True)
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
        f"(setsid sh -c '{PIDS}' &); sleep 60",
        f"(env -i PATH=$PATH sh -c '{PIDS}' &); sleep 60",
        f"(setsid sh -c '(setsid sh -c \"{PIDS}\" &); {PIDS}' &)",
    ],
    ids=["deaf", "in a session of its own", "with nothing in its environment", "two of whom the first has ended"],
)
@pytest.mark.parametrize("frozen", ["the process", "the reaper", "both", "none"])
def test_nothing_is_left_two_seconds_after_the_executive_is_killed(executive, line, frozen):
    popen, reaper, found = executive(line, 2 if "two" in line or line.count("setsid") > 1 else 1)
    for pid in {"the process": found, "the reaper": [reaper], "both": [*found, reaper], "none": []}[frozen]:
        os.kill(pid, signal.SIGSTOP)
    kill(popen)
    until(lambda: not any(map(lives, [*found, reaper])), limit_s=2.0, what="nothing is left")


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
            until(lambda: is_free(held.fileno()), limit_s=2.0, what="no process holds it")
    finally:
        with suppress(ProcessLookupError):
            os.killpg(group, signal.SIGKILL)


def is_free(fd: int) -> bool:
    with suppress(BlockingIOError):
        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return True
    return False


def test_a_guard_is_not_killed_but_continued_until_its_time_is_over(executive):
    line = f"{lifeline.LAST_WORD}=2 setsid sh -c 'echo $$ >> pids; kill -STOP $$; : > spoken; exec sleep 60'"
    popen, reaper, (guard,) = executive(line, 1)
    until(lambda: Path(f"/proc/{guard}/stat").read_text().rpartition(")")[2].split()[0] == "T")
    killed = kill(popen)
    until(Path("spoken").exists)
    assert lives(guard)
    until(lambda: not lives(guard) and not lives(reaper))
    assert time.monotonic() - killed >= 2.0


def test_a_reaper_that_dies_is_replaced_and_knows_what_runs(tmp_path):
    with closing(Reaper()) as reaper:
        mark = reaper.mark()
        started = programs.start(["/bin/sleep", "60"], start_new_session=True)  # by its session alone
        mark.began(started.pid)
        first = reaper._popen.pid
        os.kill(first, signal.SIGKILL)
        until(lambda: reaper.step() == "" and reaper._popen.pid != first)
    assert started.wait(2.0) == -signal.SIGKILL


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
        until(lambda: not lives(first), limit_s=2.0)
        assert lives(second)
    assert running[1].wait(2.0) == -signal.SIGKILL
    until(lambda: not lives(second), limit_s=2.0)


def test_what_a_stopped_command_has_started_ends_with_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = f"(setsid sh -c '{PIDS}' &); exec sleep 60"
    row = ExternalCommandRow(name="probe", argv=("/bin/sh", "-c", line), blocking=False)
    with closing(Reaper()) as reaper, closing(ExternalCommands(tmp_path, "lbr", reaper)) as commands:
        commands.start(row, ())
        (pid,) = until(lambda: pids(tmp_path))
        assert "has ended" in commands.stop("probe")
        until(lambda: not lives(pid), limit_s=2.0)


def test_frozen_commands_hold_up_the_end_of_the_robot_once_and_not_one_after_the_other(tmp_path):
    with closing(Reaper()) as reaper:
        commands = ExternalCommands(tmp_path, "lbr", reaper)
        for number in range(5):
            row = ExternalCommandRow(name=f"probe{number}", argv=("/bin/sleep", "60"), blocking=False)
            os.kill(commands.start(row, ()).pid, signal.SIGSTOP)
        began = time.monotonic()
        commands.close()
        assert time.monotonic() - began < 1.0


def test_a_process_that_was_frozen_goes_on_when_its_pipe_hangs_up():
    theirs, ours = os.pipe()
    popen = programs.start(["/bin/cat"], stdin=theirs)
    lifeline.wake(theirs, popen.pid)
    os.close(theirs)
    popen.send_signal(signal.SIGSTOP)
    assert os.waitid(os.P_PID, popen.pid, os.WSTOPPED) is not None
    os.close(ours)
    assert popen.wait(1.0) == 0


def test_a_reaper_that_is_frozen_anew_after_the_end_of_the_executive_goes_on(executive):
    popen, reaper, (pid,) = executive(PIDS, 1)
    popen.kill()
    until(lambda: takes(reaper, signal.SIGCONT), limit_s=1.0)
    os.kill(reaper, signal.SIGSTOP)
    os.kill(pid, signal.SIGSTOP)
    until(lambda: not lives(pid), limit_s=2.0)


def takes(pid: int, number: int) -> bool:
    """Say whether a process takes a signal itself."""
    status = Path(f"/proc/{pid}/status").read_text()
    caught = next(line for line in status.splitlines() if line.startswith("SigCgt:"))
    return bool(int(caught.split()[1], 16) >> (number - 1) & 1)


def test_a_tethered_process_dies_with_its_parent_also_when_it_is_frozen(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = "import sys; from subprocess import run; from lbr.capability.tether import tethered; run(tethered(('/bin/sh', '-c', sys.argv[1])))"
    parent = programs.start([sys.executable, "-c", line, PIDS])
    (pid,) = until(lambda: pids(tmp_path))
    os.kill(pid, signal.SIGSTOP)
    parent.kill()
    parent.wait()
    until(lambda: not lives(pid), limit_s=1.0)
