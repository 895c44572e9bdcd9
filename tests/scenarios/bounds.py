"""S18: bounded moves end by time and by range, measured at the motors."""

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from lbr.bus import stamp, wire
from tests.support.bench import ALMOST, ANGLES, ATTEMPTS, Bench, NoMotionError, bench
from tests.support.figures import Results
from tests.support.mover import POWER, accepted
from tests.support.waiting import HANG_S, STOPS_S

INTERVAL_EARLY_MS, INTERVAL_LATE_MS = -20.0, 40.0
RENEW_S, LEASE_S = 0.1, 1.0
"""These moves end by their bounds: the lease is long enough for a sender that a busy machine holds up."""
WALL_NEAR_CM, WALL_FAR_CM, WALL_OFF_CM = 380.0, 415.0, 3.0
FAR_M, NEAR_M, TARGET_CM = 1.5, 0.6, 90.0


def interval(under_test: Bench) -> None:
    """A move of a given time ends on time: not before that since it was asked for, nor long after it was accepted."""
    interval_s = round(under_test.dice.uniform(0.4, 0.8), 2)
    for _ in range(ATTEMPTS):
        under_test.until(lambda: under_test.trace.now().zero, HANG_S, "rest")
        before, asked_ns = _ended(under_test)["goal"], time.monotonic_ns()
        with held(under_test, {"interval_s": interval_s}) as accepted_ns:
            ended = _next_end(under_test, before)
            zero = under_test.trace.first_zero(asked_ns, STOPS_S)
        if zero is None and under_test.trace.outputs(asked_ns):
            under_test.results.check("S18 interval", [f"a move of {interval_s:g} s never ended"])
            return
        if zero is not None:
            late_ms, early_ms = ((zero.at_ns - at_ns) * 1e-6 - interval_s * 1000 for at_ns in (accepted_ns, asked_ns))
            early = early_ms < INTERVAL_EARLY_MS
            if not early or (ended["result"] == "interval" and ended["elapsed_s"] < interval_s):
                under_test.results.sample("S18 interval", max(0.0, late_ms, -early_ms))
                wrong = [f"a move of {interval_s:g} s ended {-early_ms:.1f} ms early"] if early else []
                under_test.results.check("S18 interval", wrong)
                under_test.stays_at_rest(zero)
                return
        under_test.results.repeated.append(f"a timed move: the wheels stood before its time: {ended['reason']}")
    under_test.results.disturbed.append("S18 interval: the wheels stood before its time")


def range_crossed(under_test: Bench) -> None:
    """A move to a range ends when the sensor's frame says so; the sensor is pinned far, then near."""
    for _ in range(ATTEMPTS):
        _pin(under_test, FAR_M)
        _see(under_test, lambda metres: metres > 1.0)
        with suppress(NoMotionError), held(under_test, {"range_cm": TARGET_CM, "sensor": "forward"}):
            under_test.wait_for_motion(1.5)
            _pin(under_test, NEAR_M)
            frame_ns = _see(under_test, lambda metres: metres < 1.0)
            under_test.trace.read()
            if under_test.trace.at(frame_ns).least >= ALMOST:
                under_test.stays_at_rest(under_test.stopped_after("S18 range", frame_ns))
                break
        under_test.results.repeated.append("a move to a range: the motors did not turn until it was crossed")
    _pin(under_test, None)


def wall_approached(under_test: Bench) -> None:
    """Drive towards the real wall to one distance, and back to another; it is slow by the time that it is there."""
    _until_range(under_test, 0.0, WALL_NEAR_CM)
    _until_range(under_test, 180.0, WALL_FAR_CM)


def bounds(results: Results, n: int) -> None:
    """S18."""
    with bench(results) as under_test:
        for _ in range(max(1, n // 4)):
            wall_approached(under_test)
        for _ in range(n):
            interval(under_test)
            range_crossed(under_test)


def _ended(under_test: Bench) -> dict[str, Any]:
    """Return how the newest bounded move ended."""
    return under_test.robot.ask("drive/result", timeout_s=HANG_S) or {"goal": ""}


def _next_end(under_test: Bench, before: str) -> dict[str, Any]:
    under_test.until(lambda: _ended(under_test)["goal"] != before, HANG_S, "the end of the move")
    return _ended(under_test)


def _until_range(under_test: Bench, angle_deg: float, range_cm: float) -> None:
    before = _ended(under_test)["goal"]
    with held(under_test, {"angle_deg": angle_deg, "range_cm": range_cm, "sensor": "forward"}):
        under_test.wait_for_motion()
        ended = _next_end(under_test, before)
        under_test.until(lambda: under_test.trace.now().zero, HANG_S, "standing there")
    seen_cm = under_test.robot.ask("ranges/readings")["forward_m"] * 100
    wrong = ended["result"] != "reached" or abs(seen_cm - range_cm) > WALL_OFF_CM
    under_test.results.check("S18 range", [f"{range_cm:g} cm: {ended}, {seen_cm:.1f} cm are seen"] if wrong else [])
    under_test.stays_at_rest(under_test.trace.now())


@contextmanager
def held(under_test: Bench, limits: dict[str, Any]) -> Iterator[int]:
    """Start a bounded move, give the moment of its acceptance, and renew its lease until a little after the block."""
    robot = under_test.robot
    command = {"power": POWER, "angle_deg": under_test.dice.choice(ANGLES), "ttl_s": LEASE_S} | limits
    lease = accepted(robot, command)
    accepted_ns = time.monotonic_ns()
    over = threading.Event()

    def renew() -> None:
        while not over.wait(RENEW_S):
            robot.put("drive/command", command | {"lease": lease}, source="bench")

    renewing = threading.Thread(target=renew, daemon=True)
    renewing.start()
    try:
        yield accepted_ns
        over.wait(0.15)
    finally:
        over.set()
        renewing.join()


def _pin(under_test: Bench, metres: float | None) -> None:
    request = {"device": "range_board", "name": "range_forward_m", "value": metres}
    reply = under_test.answer("world/fault", request)
    assert reply["accepted"], reply


def _see(under_test: Bench, wanted: Callable[[float], bool]) -> int:
    """Wait for the first frame whose forward distance is as wanted; return when the driver had it."""
    robot = under_test.robot
    frames = wire.Subscription(robot.bus, f"{robot.name}/ranges/readings", depth=64)
    try:
        end = time.monotonic() + HANG_S
        while time.monotonic() < end:
            for raw in frames.take():
                metres = json.loads(raw.payload)["forward_m"]
                found = stamp.read(raw.attachment)
                if metres is not None and wanted(metres) and found is not None:
                    return found.mono_ns
            under_test.pass_time(0.002)
    finally:
        frames.close()
    raise AssertionError("the range board never showed what it was pinned to")
