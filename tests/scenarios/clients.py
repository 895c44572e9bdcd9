"""S8: whoever drives is gone, in every way there is."""

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tests.support import programs
from tests.support.bench import ANGLES, STARTS_S, Bench, NoMotionError
from tests.support.clients import plain
from tests.support.clients.terminal import OnTerminal
from tests.support.mover import POWER
from tests.support.robot import LBR, environment
from tests.support.waiting import HANG_S

AFTERMATH_S = 0.3


def plain_client_killed(under_test: Bench) -> None:
    """Kill a client that imports nothing but zenoh and json."""
    with plain_client(under_test) as popen:
        _gone(under_test, "S8", lambda: under_test.kill(popen.pid))


def plain_client_leaves(under_test: Bench) -> None:
    """A client closes its session without a stop: the lease lapses."""

    def leave() -> int:
        at_ns = time.monotonic_ns()
        assert popen.stdin is not None
        popen.stdin.close()
        return at_ns

    with plain_client(under_test) as popen:
        _gone(under_test, "S8", leave)
        popen.wait(HANG_S)


def send_killed(under_test: Bench) -> None:
    """Kill `lbr send` while it holds a motion."""
    with _send(under_test) as popen:
        _gone(under_test, "S8", lambda: under_test.kill(popen.pid))
        popen.wait(HANG_S)


def send_interrupted(under_test: Bench) -> None:
    """Ctrl-C on `lbr send`: it stops what it moves."""
    with _send(under_test) as popen:
        _gone(under_test, "S8 clean", lambda: under_test.kill(popen.pid, signal.SIGINT))
        popen.wait(HANG_S)


def console_killed(under_test: Bench) -> None:
    """Kill a console on a terminal."""
    with _console(under_test) as console:
        _gone(under_test, "S8", lambda: under_test.kill(console.popen.pid))


def console_hung_up(under_test: Bench) -> None:
    """Close the terminal under a console."""

    def hang_up() -> int:
        at_ns = time.monotonic_ns()
        console.hang_up()
        return at_ns

    with _console(under_test) as console:
        _gone(under_test, "S8", hang_up)
        console.popen.wait(HANG_S)


def console_left(under_test: Bench) -> None:
    """Leave a console by end of input."""

    def leave() -> int:
        at_ns = time.monotonic_ns()
        console.type(b"\x04")
        return at_ns

    with _console(under_test) as console:
        _gone(under_test, "S8 clean", leave)
        console.popen.wait(HANG_S)


WAYS: tuple[Callable[[Bench], None], ...] = (
    plain_client_killed,
    plain_client_leaves,
    send_killed,
    send_interrupted,
    console_killed,
    console_hung_up,
    console_left,
)


def _gone(under_test: Bench, figure: str, leave: Callable[[], int]) -> None:
    try:
        under_test.wait_for_motion(STARTS_S)
    except NoMotionError:
        leave()
        raise
    fault_ns = leave()
    zero = under_test.stopped_after(figure, fault_ns)
    under_test.pass_time(AFTERMATH_S)
    under_test.stays_at_rest(zero)


def _angle(under_test: Bench) -> float:
    return under_test.dice.choice(ANGLES)


def plain_client(under_test: Bench) -> "subprocess.Popen[str]":
    """Start a client that imports nothing but zenoh and json, and drives until it is told to end."""
    robot = under_test.robot
    return programs.start(
        [sys.executable, plain.__file__, robot.endpoints[0], robot.name, str(_angle(under_test))],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
    )


def _send(under_test: Bench) -> "subprocess.Popen[bytes]":
    return programs.start(
        [*LBR, "send", f"/r/{POWER}/{_angle(under_test):g}"],
        env=environment(under_test.robot.home),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


@contextmanager
def _console(under_test: Bench) -> Iterator[OnTerminal]:
    console = OnTerminal(under_test.robot.home, [*LBR, "console"])
    try:
        console.wait_for(b"Robot>")
        console.type(f"/r/{POWER}/{_angle(under_test):g}\r".encode())
        yield console
    finally:
        console.end()
