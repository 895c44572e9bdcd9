"""The time from a console line to bytes at the motor controller, and the share of the bus in it.

`python -m benchmarks latency --n 500`. The robot spins at 40 % and slows down in steps: less power takes effect at
once, more of it only within the slew. Between any two lines the same machine, in the same state, sends one message
through a bare zenoh client - router - client chain and one through two JoinableQueue hops. Exit code 1 if a line took
longer than the hard limit.
"""

import argparse
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import msgspec

from benchmarks import Measured
from benchmarks.instruments.queues import TwoHops, two_hops
from lbr.bus import keys, stamp, wire
from tests.scenarios.promises import PROMISES
from tests.support import programs
from tests.support.bench import Bench, bench
from tests.support.clients import echo
from tests.support.figures import STATISTICS, Promise, Results, percentile
from tests.support.trace import Line

SMOKE = "--n 6"

LINE = {"line": Promise(what="console line to motor bytes", hard=250.0)}
STEPS = (0.35, 0.30, 0.25, 0.20, 0.15, 0.10)
ANGLE_DEG = 90.0
MESSAGE = {"left": 0.4, "right": -0.4, "lease": "0123456789abcdef"}


def options(parser: argparse.ArgumentParser) -> None:
    """Add the number of lines."""
    parser.add_argument("--n", type=int, default=500, help="lines (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Send lines, and messages by other ways between them."""
    with bench(Results(PROMISES)) as under_test, _echo(under_test), two_hops() as queues:
        series = _measure(under_test, queues, given.n)
    results = Results(LINE)
    for sample in series["console line to motor bytes"]:
        results.sample("line", sample)
    text = ["", "| path, ms | N | p50 | p99 | max |", "|---|--:|--:|--:|--:|"]
    for name, samples in series.items():
        shown = [f"{percentile(samples, which):.3f}" for which in STATISTICS]
        text.append(f"| {name} | {len(samples)} | {' | '.join(shown)} |")
    line, _answer, hop, bare, old = series.values()
    share = 3 * percentile(bare, "p50") / percentile(line, "p50")
    text += [
        f"\none hop of the bus, lbr's to bare zenoh's: {_ratio(hop, bare)}",
        f"line to motor bytes, to two queue hops:    {_ratio(line, old)}",
        f"three bare hops are {share:.0%} of a line to motor bytes",
    ]
    return Measured(results=results.ordered(), text="\n".join(text))


class Setpoints:
    """Receives the setpoints in the driver's place, at the core router, with their times on the bus."""

    def __init__(self, under_test: Bench) -> None:
        key = keys.port(under_test.robot.name, "motors", "setpoint")
        self.hop_ms: list[float] = []
        self._bus = under_test.robot.as_owner()
        self._subscriber = self._bus.declare_subscriber(key, wire.direct(self._hear))

    def close(self) -> None:
        self._bus.close()

    def _hear(self, sample: Any) -> None:
        at_ns = time.monotonic_ns()
        found = stamp.read(sample.attachment.to_bytes())
        if found is not None:
            self.hop_ms.append((at_ns - found.mono_ns) * 1e-6)


class PingPong:
    """A bare zenoh round trip over the robot's router, with the size of a stamped setpoint."""

    def __init__(self, under_test: Bench) -> None:
        self._bus = under_test.robot.bus
        self._back_ns = 0
        self._payload = msgspec.json.encode(MESSAGE)
        self._stamp = stamp.make("drive", 1, self._payload, b"key")
        self._publisher = self._bus.declare_publisher("bench/ping", encoding=wire.JSON)
        self._subscriber = self._bus.declare_subscriber("bench/pong", wire.direct(self._hear))

    def once(self) -> float | None:
        """Return half of a round trip in milliseconds, None if it was lost."""
        self._back_ns = 0
        at_ns = time.monotonic_ns()
        self._publisher.put(self._payload, attachment=self._stamp)
        while not self._back_ns:
            if time.monotonic_ns() - at_ns > 1e9:
                return None
            Bench.pass_time(0.0005)
        return (self._back_ns - at_ns) * 0.5e-6

    def _hear(self, _sample: Any) -> None:
        self._back_ns = time.monotonic_ns()


def _measure(under_test: Bench, queues: TwoHops, n: int) -> dict[str, list[float]]:
    setpoints, ping = Setpoints(under_test), PingPong(under_test)
    lines: list[float] = []
    answers: list[float] = []
    bare: list[float] = []
    old: list[float] = []
    while len(lines) < n:
        _spin(under_test)
        for power in STEPS:
            measured = _slow_down(under_test, power)
            if measured is None:
                break  # the machine was busy for too long and the robot stands; start over
            lines.append(measured[0])
            answers.append(measured[1])
            if (half := ping.once()) is not None:
                bare.append(half)
            old.append(queues.once(MESSAGE))
            under_test.pass_time(under_test.dice.uniform(0.0, 0.02))
    setpoints.close()
    return {
        "console line to motor bytes": lines,
        "console line to its answer": answers,
        "one setpoint on the bus": setpoints.hop_ms,
        "bare zenoh, half a round trip": bare,
        "two JoinableQueue hops": old,
    }


def _spin(under_test: Bench) -> None:
    """Bring the robot to 40 % by console lines."""

    def turning() -> bool:
        under_test.robot.line(f"/r/0.4/{ANGLE_DEG:g}")
        under_test.pass_time(0.05)
        return under_test.trace.now().least >= 0.39

    under_test.until(turning, 5.0, "spinning")


def _slow_down(under_test: Bench, power: float) -> tuple[float, float] | None:
    """Send a line; return the milliseconds until the controller received the new power, and until the answer."""
    wanted = round(power * 1000)
    under_test.trace.read()
    at_ns = time.monotonic_ns()
    said = under_test.robot.line(f"/r/{power:g}/{ANGLE_DEG:g}")
    answered_ns = time.monotonic_ns()
    if said["code"] != 0:
        return None
    end_ns = at_ns + 1_000_000_000
    while time.monotonic_ns() < end_ns:
        for entry in under_test.trace.read():
            if isinstance(entry, Line) and entry.at_ns >= at_ns and _powers(entry) == {wanted}:
                return (entry.at_ns - at_ns) * 1e-6, (answered_ns - at_ns) * 1e-6
        under_test.pass_time(0.001)
    return None


def _powers(line: Line) -> set[int]:
    words = line.text.split()
    return {abs(int(word)) for word in words[1:]} if words[0] == "!M" else set()


def _ratio(ours: list[float], theirs: list[float]) -> str:
    p50, p99 = (percentile(ours, which) / percentile(theirs, which) for which in ("p50", "p99"))
    return f"{p50:.2f} at p50, {p99:.2f} at p99"


@contextmanager
def _echo(under_test: Bench) -> Iterator[None]:
    endpoint = under_test.robot.endpoints[0]
    popen = programs.start(
        [sys.executable, echo.__file__, endpoint], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert popen.stdout is not None
    if popen.stdout.readline().strip() != "ready":
        raise AssertionError("the echo did not start")
    try:
        yield
    finally:
        popen.communicate()
