"""Stops from a shell: an executive that stands still, and several robots on one machine."""

import os
import signal
import subprocess

import pytest

from tests.support import programs
from tests.support import robot as robots
from tests.support.commands import here


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """Two robots of one home, without any part."""
    home = robots.prepare(tmp_path_factory.mktemp("h"), edits=(robots.only("lbr"), robots.only("uxa90")))
    with robots.running(home) as one, robots.running(home, profile="uxa90-sim") as other:
        yield one, other


def test_a_stop_that_names_no_robot_reaches_all_that_run_here_and_nothing_else_does(both):
    one, other = both
    done = here(one.home, "send", "estop/too", "near")
    assert done.returncode == 0, done.stderr
    assert sorted(line.split(":")[0] for line in done.stdout.splitlines()) == ["lbr", "uxa90"]
    for robot in both:
        found = robot.ask("@estop")
        assert (found["engaged"], found["reason"]) == (True, "too near")
    refused = here(one.home, "send", "reset")
    assert refused.returncode == 2
    assert "--robot NAME" in refused.stderr
    assert here(one.home, "send", "--robot", "lbr", "reset").returncode == 0
    assert other.ask("@estop")["engaged"]
    assert other.line("reset")["code"] == 0


def test_a_stop_to_several_robots_tells_what_each_answers_without_waiting_for_one_that_hangs(both):
    one, _ = both
    os.kill(one.popen.pid, signal.SIGSTOP)
    sent = programs.start(
        [*robots.LBR, "send", "s"],
        env=robots.environment(one.home),
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        assert sent.stdout.readline().startswith("uxa90: ")
    finally:
        os.kill(one.popen.pid, signal.SIGCONT)
        rest, _ = sent.communicate()
    assert rest.startswith("lbr: "), "it answered once it went on, and had not been given up"


def test_a_frozen_robot_is_shut_down_as_any_other(both):
    """The last one here: it ends one of them."""
    one, _ = both
    os.kill(one.popen.pid, signal.SIGSTOP)
    done = robots.lbr(one.home, "stop", "--robot", "lbr")
    assert (done.returncode, done.stdout) == (0, "robot 'lbr' has shut down\n")
    assert one.popen.wait(5.0) == 0
