"""S21: the operator's terminal is frozen, or its far end is gone."""

import signal
import time
from contextlib import suppress

from tests.support.bench import ANGLES, ATTEMPTS, Bench, bench
from tests.support.clients.terminal import OnTerminal
from tests.support.figures import Results
from tests.support.mover import POWER
from tests.support.robot import LBR

QUESTION = b"\x1b[6n"
MUCH = b"help\r" * 6
"""More than a terminal takes that nobody reads."""
GONE_S = 10.0


def unread(results: Results, n: int) -> None:
    """S21, all ways in turn."""
    with bench(results) as under_test:
        for turn in range(n):
            _frozen(under_test, b"\x03" if turn % 2 else signal.SIGTERM)
            _gone(under_test)


def _frozen(under_test: Bench, way: bytes | signal.Signals) -> None:
    """Freeze a terminal that is asked nothing: a stop is heard, what moves is stopped, and the console can be left."""
    console = _console(under_test, answers=False)
    try:
        _drive(under_test, console)
        console.freeze()
        zero = under_test.stopped_after("S21 s", _typed(console, b"s\r"))
        under_test.stays_at_rest(zero)
        _drive(under_test, console)
        zero = under_test.stopped_after("S21 full", _typed(console, MUCH), limit_s=3.0)
        under_test.stays_at_rest(zero)
        at_ns = _typed(console, way) if isinstance(way, bytes) else under_test.kill(console.popen.pid, way)
        console.popen.wait(GONE_S)
        under_test.results.sample("S21 left", (time.monotonic_ns() - at_ns) * 1e-6)
    finally:
        console.end()


def _gone(under_test: Bench) -> None:
    """Freeze a terminal that has answered: that it does no more is the only sign there is."""
    console = _console(under_test, answers=True)
    try:
        _drive(under_test, console)
        asked = console.said.count(QUESTION)
        under_test.until(lambda: console.said.count(QUESTION) > asked + 1, 3.0, "questions")
        at_ns = time.monotonic_ns()
        console.freeze()
        zero = under_test.stopped_after("S21 silent", at_ns, limit_s=3.0)
        under_test.stays_at_rest(zero)
    finally:
        console.end()


def _console(under_test: Bench, *, answers: bool) -> OnTerminal:
    console = OnTerminal(under_test.robot.home, [*LBR, "console"], answers=answers)
    console.wait_for(b"Robot>")
    return console


def _drive(under_test: Bench, console: OnTerminal) -> None:
    """Say a line until the motors turn: a machine that was busy for 0.1 s has disarmed them."""
    line = f"/r/{POWER}/{under_test.dice.choice(ANGLES):g}\r".encode()
    for _ in range(ATTEMPTS - 1):
        console.type(line)
        with suppress(AssertionError):
            under_test.wait_for_motion(1.5)
            return
    console.type(line)
    under_test.wait_for_motion()


def _typed(console: OnTerminal, keys: bytes) -> int:
    at_ns = time.monotonic_ns()
    console.type(keys)
    return at_ns
