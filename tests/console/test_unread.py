"""Consoles of a real robot whose output is not read: the robot stops, and whoever is told to end ends."""

import fcntl
import math
import os
import signal
import subprocess
import sys
import termios
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from lbr.bus import wire
from tests.support import programs
from tests.support import robot as robots
from tests.support.clients.terminal import OnTerminal
from tests.support.robot import LBR, environment
from tests.support.waiting import STOPS_S, until

TURN = "/r/0.4/90"
AGAIN_S = 2.0
"""Longer than the way of a line to the wheels: those that still stand have been stopped."""


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    with robots.running(robots.prepare(tmp_path_factory.mktemp("h"), edits=robots.PATIENT)) as robot:
        yield robot


@contextmanager
def flooded(robot) -> Iterator[None]:
    """Let the robot tell more than a frozen terminal takes."""
    over = threading.Event()
    with robot.as_owner() as bus:

        def tell() -> None:
            number = 0
            while not over.wait(0.005):
                number += 1
                event = {"kind": "test", "subject": "x", "text": f"{number} {'y' * 500}", "level": "warning"}
                wire.put(bus, f"{robot.name}/@event", event, source="test")

        teller = threading.Thread(target=tell)
        teller.start()
        try:
            yield
        finally:
            over.set()
            teller.join()


@pytest.mark.parametrize("stop", ["s", "estop"])
def test_a_stop_with_the_beginning_of_a_terminals_answer_whose_rest_comes_later_stops_what_drives(robot, trace, stop):
    with terminal(robot, "console") as person:
        person.type(b"/r/0.2/90\r")
        until(lambda: trace.now().least > 0.1, what="motion")
        person.type(f"{stop}\x1b".encode())
        threading.Event().wait(0.6)
        person.type(b"[20;1R\r")
        until(lambda: trace.now().zero, what="rest", limit_s=STOPS_S)
        if stop == "estop":
            until(lambda: robot.status()["estop"]["engaged"], what="its latch")
            robot.line("reset")


@contextmanager
def terminal(robot, *command: str, answers: bool = True) -> Iterator[OnTerminal]:
    on = OnTerminal(robot.home, [*LBR, *command], answers=answers)
    try:
        shows(on, b"Robot>")
        yield on
    finally:
        on.end()


def full_pipe() -> tuple[int, int]:
    """Return the ends of a pipe that takes no byte more."""
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    try:
        while True:
            os.write(writer, b"x" * 4096)
    except BlockingIOError:
        os.set_blocking(writer, True)
    return reader, writer


@contextmanager
def into_full_pipe(robot, *command: str) -> "Iterator[subprocess.Popen[bytes]]":
    reader, writer = full_pipe()
    popen = programs.start(
        [*LBR, *command], env=environment(robot.home), stdin=subprocess.PIPE, stdout=writer, stderr=subprocess.DEVNULL
    )
    os.close(writer)
    try:
        yield popen
    finally:
        popen.kill()
        popen.communicate()
        os.close(reader)


def say(popen: "subprocess.Popen[bytes]", line: str) -> None:
    popen.stdin.write(f"{line}\n".encode())
    popen.stdin.flush()


def shows(on: OnTerminal, text: bytes) -> None:
    until(lambda: text in on.said, what=f"{text!r} on the terminal")


def ended(popen: "subprocess.Popen[bytes]") -> int | None:
    """Return a program's exit code, once it has one."""
    until(lambda: popen.poll() is not None, what="an end")
    return popen.returncode


def unread(fd: int) -> int:
    return int.from_bytes(fcntl.ioctl(fd, termios.FIONREAD, bytes(4)), sys.byteorder)


def turns(trace, say: Callable[[], object]) -> None:
    """Have a console say the turn until the wheels turn: one that a busy machine held up has stopped them."""
    said_s = -math.inf

    def look() -> bool:
        nonlocal said_s
        if trace.now().zero and time.monotonic() - said_s > AGAIN_S:
            said_s = time.monotonic()
            say()
        return trace.now().least >= 0.3

    until(look, what="motion")


def at_rest(trace) -> None:
    until(lambda: trace.now().zero, what="rest")


def test_a_terminal_that_takes_no_output_stops_the_wheels(robot, trace):
    with terminal(robot, "console", answers=False) as on:
        with flooded(robot):
            turns(trace, lambda: on.type(f"{TURN}\r".encode()))
            on.freeze()
            at_rest(trace)
        on.thaw()
        # a busy machine has reasons of its own, or answers too late; that of a terminal is tried in test_terminal.py
        ends = (f"{TURN}: ".encode(), b"say it again")
        until(lambda: any(end in on.said for end in ends), what="its end, on the terminal")


def test_a_terminal_that_answers_no_more_stops_the_wheels(robot, trace):
    with terminal(robot, "console") as on:
        say = lambda: on.type(f"{TURN}\r".encode())  # noqa: E731
        until(lambda: (turns(trace, say), on.said.count(b"\x1b[6n") > 2)[1], what="motion while the terminal answers")
        on.freeze()
        at_rest(trace)


def test_a_stop_is_heard_from_a_pipe_when_nobody_reads_the_results(robot, trace):
    with into_full_pipe(robot, "console") as popen:
        turns(trace, lambda: say(popen, TURN))
        say(popen, "stop")
        at_rest(trace)
        popen.terminate()
        assert ended(popen) == 130


def test_what_is_sent_into_a_full_pipe_is_not_held(robot, trace):
    with into_full_pipe(robot, "send", TURN, "--hold", "20") as popen:
        until(lambda: trace.now().least >= 0.3, what="motion")
        at_rest(trace)
        popen.send_signal(signal.SIGINT)
        assert ended(popen) == 130


def test_who_prints_into_a_pipe_that_is_read_no_more_can_be_interrupted(robot):
    reader, writer = os.pipe()
    fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, 4096)
    os.write(writer, b"x" * 2500)
    popen = programs.start([*LBR, "topic", "echo", "drive/state"], env=environment(robot.home), stdout=writer)
    os.close(writer)
    try:
        until(lambda: unread(reader) > 3000, what="a full pipe")
        popen.send_signal(signal.SIGINT)
        assert ended(popen) == 130
    finally:
        popen.kill()
        popen.wait()
        os.close(reader)


def test_a_view_on_a_frozen_terminal_can_be_left(robot):
    on = OnTerminal(robot.home, [*LBR, "view"])
    try:
        shows(on, b"[?1049h")
        on.freeze()
        until(lambda: on.unread > 3000)
        on.popen.send_signal(signal.SIGINT)
        assert ended(on.popen) == 130
    finally:
        on.end()


@pytest.mark.parametrize("way", [signal.SIGTERM, signal.SIGHUP])
def test_the_robots_own_terminal_ends_it_though_frozen(tmp_path, way):
    on = OnTerminal(robots.prepare(tmp_path / "h"), [*LBR, "run"], answers=False)
    try:
        shows(on, b"ready")
        on.freeze()
        on.type(b"!print('z' * 100000)\r")
        until(lambda: on.unread > 3000)
        on.popen.send_signal(way)
        assert ended(on.popen) == 0
    finally:
        on.end()


def test_the_ready_line_holds_up_no_robot(tmp_path):
    home = robots.prepare(tmp_path / "h")
    reader, writer = full_pipe()
    popen = programs.start([*LBR, "run", "--no-console"], env=environment(home), stdout=writer)
    os.close(writer)
    try:
        until(lambda: '"ready":true' in robots.lbr(home, "status", "--json").stdout)
        popen.terminate()
        assert ended(popen) == 0
    finally:
        popen.kill()
        popen.wait()
        os.close(reader)


def test_commands_that_talk_to_a_robot_say_that_they_cannot_print(robot):
    for command in (["status"], ["send", "/r/0.1/90", "--hold", "9"], ["console"]):
        with Path("/dev/full").open("w") as full:
            done = programs.run(
                [*LBR, *command],
                env=environment(robot.home),
                input=b"s\n",
                stdout=full,
                stderr=subprocess.PIPE,
                timeout=8,  # less than what it would hold
                check=False,
            )
        assert done.returncode == 1
        assert done.stderr.startswith(b"lbr: standard output cannot be written")


@pytest.mark.parametrize("way", [b"\x03", b"\x04", signal.SIGTERM, signal.SIGHUP])
def test_a_console_on_a_frozen_terminal_can_be_left(robot, trace, way):
    with terminal(robot, "console", answers=False) as on, flooded(robot):
        on.freeze()
        until(lambda: on.unread > 3000)
        if isinstance(way, bytes):
            on.type(way)
        else:
            on.popen.send_signal(way)
        assert ended(on.popen) == 0


def test_a_console_into_a_full_pipe_leaves_when_told(robot, trace):
    with into_full_pipe(robot, "console") as popen:
        turns(trace, lambda: say(popen, TURN))
        popen.terminate()
        assert ended(popen) == 130
        at_rest(trace)
