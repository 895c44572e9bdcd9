"""A shutdown ends the process, whatever its main thread hangs in."""

import itertools
import queue
import select
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from lbr.cli import INTERRUPTED
from lbr.executive.shutdown import FORCED, Shutdown
from tests.scenarios.many_rows import ADD_MANY, FITTING
from tests.support import programs
from tests.support.robot import environment, prepare, running
from tests.support.waiting import HANG_S, until

HANGS = """
import os, signal, sys, threading
from lbr.cli import INTERRUPTED
from lbr.executive.shutdown import SIGNALS, Shutdown

shutdown = Shutdown(lambda: None, signals=SIGNALS, heard_s=0.2)
signal.set_wakeup_fd(shutdown.signal_fd)
signal.signal(signal.SIGTERM, lambda *_: None)
lock = os.pipe()
print("hangs", flush=True)
while True:
    try:
        os.read(lock[0], 1)
    except InterruptedError:
        pass
"""

LOSES_CTRL_C = """
import signal, sys
from lbr import start
from lbr.executive.planning import joining

join = joining.join

def loses(*given):
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        return join(*given)

joining.join = loses
sys.argv = ["lbr", "run", "--no-console"]
sys.exit(start.main())
"""


def test_a_ctrl_c_that_was_lost_while_a_robot_was_loaded_ends_it_before_it_starts(tmp_path) -> None:
    home = prepare(tmp_path / "h")
    done = programs.run(
        [sys.executable, "-c", LOSES_CTRL_C],
        env=environment(home),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=HANG_S,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr.strip()) == (INTERRUPTED, b"", b"")


def test_sigterm_ends_a_process_whose_main_thread_never_returns(wording) -> None:
    popen = programs.start([sys.executable, "-c", HANGS], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    with popen:
        assert popen.stdout is not None
        assert popen.stdout.readline() == "hangs\n"
        popen.send_signal(signal.SIGTERM)
        _, errors = popen.communicate(timeout=HANG_S)
    assert popen.returncode == FORCED
    wording(errors)


@pytest.mark.parametrize("heard", [False, True])
def test_it_counts_from_the_first_word_and_says_what_took_too_long(heard: bool, wording) -> None:
    ended: queue.SimpleQueue[str] = queue.SimpleQueue()
    woken = threading.Event()
    shutdown = Shutdown(woken.set, end=ended.put, heard_s=0.05 if not heard else 2 * HANG_S, over_s=0.1)
    assert ended.empty()
    if heard:
        shutdown.closing()
    shutdown.begin("signal SIGTERM")
    shutdown.begin("signal SIGTERM")
    wording(ended.get(timeout=HANG_S))


@pytest.mark.slow_start
def test_sigterm_ends_a_robot_while_many_rows_begin(tmp_path: Path) -> None:
    with running(prepare(tmp_path / "h")) as robot:
        robot.edit(ADD_MANY.format(last=FITTING - 1))
        until(lambda: any(one["phase"] == "starting" for one in robot.status()["capabilities"]))
        robot.popen.send_signal(signal.SIGTERM)
        assert robot.popen.wait(HANG_S) == 0


@pytest.mark.slow_start
def test_a_robot_that_is_told_to_end_again_and_again_ends_in_order(tmp_path: Path) -> None:
    with running(prepare(tmp_path / "h")) as robot:
        told = itertools.cycle((signal.SIGTERM, signal.SIGINT))
        end = time.monotonic() + HANG_S
        while robot.popen.poll() is None and time.monotonic() < end:
            robot.popen.send_signal(next(told))
            select.select([], [], [], 0.01)
        assert robot.popen.returncode == 0
