"""E3: a stream of commands that goes on through emergency stop and reset moves nothing; pausing or neutral does."""

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import pairwise
from typing import Any

from lbr.bus import session, wire
from lbr.bus.session import Session
from lbr.errors import BusError
from lbr.leases.rules import PERSISTENT_S
from tests.support.bench import ANGLES, Bench
from tests.support.mover import accepted

STREAM_S = 0.05
STAYS_S = 0.5
QUIET_S = 0.3
Send = Callable[[Session, float], None]


def by_line(robot: str) -> Send:
    """Console lines."""
    return lambda bus, angle: _ask(bus, f"{robot}/@console", f"/r/0.4/{angle:g}", "lines")


def by_put(robot: str) -> Send:
    """Plain puts by a client that imports nothing of ours."""
    return lambda bus, angle: bus.put(f"{robot}/drive/command", json.dumps({"power": 0.4, "angle_deg": angle}))


def by_query(robot: str) -> Send:
    """Queries, each of them a new command."""
    return lambda bus, angle: _ask(bus, f"{robot}/drive/command", {"power": 0.4, "angle_deg": angle}, "queries")


STREAMS: dict[str, Callable[[str], Send]] = {"console": by_line, "put": by_put, "query": by_query}


def reset_under_stream(under_test: Bench, how: str) -> None:
    """Press and reset under a stream; then it pauses or another begins, and the robot drives again."""
    robot = under_test.robot
    with streaming(under_test, STREAMS[how](robot.name)) as sent:
        under_test.wait_for_motion()
        said = robot.line("estop")
        assert said["code"] == 0, said
        since_ns = time.monotonic_ns()
        under_test.pass_time(under_test.dice.uniform(0.0, STAYS_S))
        under_test.release()
        under_test.pass_time(STAYS_S)
        _nothing_moved(under_test, since_ns, how, sent)
    under_test.pass_time(QUIET_S)
    accepted(robot, {"power": 0.4, "angle_deg": under_test.dice.choice(ANGLES)})
    under_test.until(lambda: not under_test.trace.now().zero, 1.0, "motion after a pause")
    robot.ask("drive/stop", {})
    under_test.until(lambda: under_test.trace.now().zero, 1.0, "rest")


@contextmanager
def streaming(under_test: Bench, send: Send) -> Iterator[list[float]]:
    """Send at 20 Hz from a session of its own, for the time of a block; give when that was, by the monotonic clock."""
    over = threading.Event()
    bus = session.open_client(under_test.robot.endpoints)
    angle = under_test.dice.choice(ANGLES)
    sent: list[float] = []

    def stream() -> None:
        while not over.wait(STREAM_S):
            with suppress(BusError):
                send(bus, angle)
            sent.append(time.monotonic())

    thread = threading.Thread(target=stream, daemon=True)
    thread.start()
    try:
        yield sent
    finally:
        over.set()
        thread.join()
        bus.close()


def _ask(bus: Session, key: str, message: Any, source: str) -> None:
    wire.ask(bus, key, message, source=source, timeout_s=1.0)


def _nothing_moved(under_test: Bench, since_ns: int, how: str, sent: list[float]) -> None:
    """Check that nothing has; a stream that the machine had pause may move the robot afterwards, and does not count."""
    zero = under_test.trace.first_zero(since_ns - 100_000_000, 1.0)
    under_test.trace.read()
    since = max(since_ns, zero.at_ns) if zero is not None else since_ns
    moved = [entry for entry in under_test.trace.outputs(since) if not entry.zero]
    pause_s = max((later - sooner for sooner, later in pairwise([*sent, time.monotonic()])), default=0.0)
    if moved and pause_s > 0.8 * PERSISTENT_S:
        under_test.results.disturbed.append(f"E3: the stream by {how} itself paused for {pause_s:.2f} s")
        return
    text = [f"a stream by {how} moved the robot after the reset: {one}" for one in moved[:1]]
    if zero is None and not under_test.trace.now().zero:  # without a zero in that time they may have stood before
        text.append(f"under a stream by {how} the motors did not come to rest")
    under_test.results.check("E3", text)
