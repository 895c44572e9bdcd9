"""How regular eighteen joints are commanded and measured, and how soon a stop is on their wire; on a simulated bus.

`python -m benchmarks.joints_cycle [--seconds 600] [--stops 60] [--json FILE]` runs the processes `servos` and `joints`
of the Bioloid on an emulated servo bus of its own process, with a USB2AX and all the line's delays. A client commands all
joints at 100 Hz, and reads every state; answers get lost and noise comes before them, 1 % each, and 1 % of the time
a servo is silent. Then, in the same traffic, a second client says `joints/stop`: measured until the last byte that
holds the last joint has crossed the line. Exit code 1 if a stop was not within 50 ms, or a joint not held.
"""

import argparse
import json
import random
import sqlite3
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import pairwise
from math import nan
from pathlib import Path
from typing import Any

import msgspec
import psutil

from benchmarks.figures import machine, percentile
from benchmarks.servo_bus import Process
from lbr.bus import keys, wire
from lbr.database import store
from lbr.errors import BusError
from lbr.messages.joints import JointsState
from tests.robot import Robot, start, until

PERIOD_S = 0.01
FAULTS = {"drop": 0.01, "garbage": 0.01}
DEAD_EVERY_S, DEAD_S = 30.0, 0.3
SPEED_RPS = 1.0
MOST_RAD = 0.3
AHEAD_S = 0.1
"""How far ahead of now each command looks; the next one comes before it is reached."""

PAUSE_S = 0.5
HELD_STEPS = 4
"""A goal that changes by no more than that is held: where a joint was measured a sweep earlier or later."""
WATCH_S = 0.3
TARGET_MS, HARD_MS = 20.0, 50.0
SYNC_WRITE, GOAL = "83", 30


class Client:
    """Commands all joints at 100 Hz under one lease, and goes on whatever the answers are."""

    def __init__(self, robot: Robot, ways: dict[str, tuple[float, float]]) -> None:
        self._robot = robot
        self._ways = ways
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._lease = ""
        self.late_ms: list[float] = []
        """By how much each command left later than it should."""

    def start(self) -> "Client":
        """Begin to move, once that is accepted."""
        until(self.again, limit_s=10.0, what="a motion that is accepted")
        self._thread.start()
        return self

    def again(self) -> bool:
        """Ask for a lease, and say whether there is one; not at once, because who goes on without one is refused."""
        self._lease = ""
        _pass_time(PAUSE_S)
        reply = self._robot.ask("joints/command", self._command(time.monotonic()), source="bench")
        accepted = reply is not None and reply["accepted"]
        self._lease = reply["lease"] if accepted else ""
        return bool(accepted)

    def cease(self) -> None:
        """Send no more."""
        self._over.set()
        self._thread.join()

    def _run(self) -> None:
        due = time.monotonic()
        while not self._over.wait(max(0.0, due - time.monotonic())):
            now = time.monotonic()
            self.late_ms.append((now - due) * 1e3)
            if lease := self._lease:
                with suppress(BusError):
                    self._robot.put("joints/command", self._command(now) | {"lease": lease}, source="bench")
            due = max(due + PERIOD_S, now)

    def _command(self, now: float) -> dict[str, Any]:
        then = now + AHEAD_S
        positions = {name: middle + most * _saw(then * SPEED_RPS / most) for name, (middle, most) in self._ways.items()}
        return {"positions": positions, "duration_s": AHEAD_S, "interpolation": "linear"}


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=600.0, help="how long the cycle is watched")
    parser.add_argument("--stops", type=int, default=60)
    parser.add_argument("--json", type=Path, help="write the figures into this file")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="lbr-") as place, running(Path(place) / "h") as (robot, twin, log, ways):
        figures: dict[str, Any] = {"machine": machine(), "seconds": options.seconds}
        figures |= cycle(robot, twin, log, ways, options.seconds)
        figures |= stops(robot, twin, log, ways, options.stops)
    print("\n".join(f"{name}: {_shown(value)}" for name, value in figures.items()))
    if options.json:
        options.json.write_bytes(msgspec.json.format(msgspec.json.encode(figures)) + b"\n")
    return 1 if figures["stops not held"] or figures["stop to held, ms"]["max"] > HARD_MS else 0


@contextmanager
def running(home: Path) -> Iterator[tuple[Robot, Process, Path, dict[str, tuple[float, float]]]]:
    """Run the two processes on an emulated bus; give the robot, the bus, its log, and how far each joint may go."""
    home.mkdir(mode=0o700)
    store.create(home / "robot.db")
    with sqlite3.connect(home / "robot.db") as database:
        database.execute(
            "UPDATE capability SET enabled = 0 WHERE robot = 'bioloid' AND name NOT IN ('servos', 'joints')"
        )
        rows = database.execute(
            "SELECT name, zero_rad, lower_rad, upper_rad FROM joint WHERE robot = 'bioloid' ORDER BY device_id"
        ).fetchall()
    database.close()
    log = home / "packets.txt"
    twin = Process(
        sys.executable, "-m", "benchmarks.servo_bus_twin", str(home / "run" / "bioloid-devices" / "servo_bus")
    )
    try:
        positions_rad = [zero_rad for _, zero_rad, _, _ in rows]
        order = {"delay": 250, "usb2ax": 5, "usb_us": 250.0, "positions_rad": positions_rad, "log": str(log)}
        _tell(twin, order)
        robot = start(home, profile="bioloid-sim")
        try:
            _switch_on(robot)
            yield robot, twin, log, {name: _way(lower, upper) for name, _, lower, upper in rows}
        finally:
            robot.close()
    finally:
        twin.close()


def cycle(
    robot: Robot, twin: Process, log: Path, ways: dict[str, tuple[float, float]], seconds: float
) -> dict[str, Any]:
    """Watch the cycle of commands and states for a while."""
    states = wire.Subscription(robot.bus, keys.port(robot.name, "joints", "state"), depth=1000)
    client = Client(robot, ways).start()
    _tell(twin, {"faults": FAULTS})
    _pass_time(1.0)
    states.take()
    begun, spent_s = time.monotonic(), _spent_s(robot)
    found = Watched()
    dead_at = begun + min(DEAD_EVERY_S, seconds) / 2
    while (now := time.monotonic()) < begun + seconds:
        if now >= dead_at:
            _tell(twin, {"faults": {**FAULTS, "silent": [random.randint(1, len(ways))]}})
            _pass_time(DEAD_S)
            _tell(twin, {"faults": FAULTS})
            dead_at += DEAD_EVERY_S
        _pass_time(0.05)
        if not found.take(states.take()):
            found.ended += client.again()
    shares = {name: (now_s - spent_s[name]) / (now - begun) for name, now_s in _spent_s(robot).items()}
    client.cease()
    states.close()
    written = [at for at, _ in goals(log) if begun <= at < begun + seconds]
    return {
        **found.figures(),
        "period error of goals on the wire, ms": _errors(written),
        "commands sent late, ms": _summary(client.late_ms),
        "share of a core": {name: round(share, 3) for name, share in shares.items()},
    }


class Watched:
    """What the states of the joints show."""

    def __init__(self) -> None:
        self.ended = 0
        """How often a motion ended, and was begun anew."""
        self._arrived: list[float] = []
        self._measured: list[float] = []
        self._ages_ms: list[float] = []
        self._lost = 0
        self._last = -1
        self._still = self._unmeasured = self._old = 0

    def take(self, messages: list[wire.Raw]) -> bool:
        """Take in states; say whether there is still a motion."""
        holder: str | None = "bench"
        for message in messages:
            state = msgspec.json.decode(message.payload, type=JointsState)
            holder = state.holder
            if state.sequence == self._last:
                continue  # told for another reason than a sweep
            self._lost += max(0, state.sequence - self._last - 1) if self._last >= 0 else 0
            self._last = state.sequence
            self._arrived.append(message.arrived)
            self._measured.append(state.measured_s)
            self._still += not state.moving
            ages_ms = [joint.age_s * 1e3 for joint in state.joints.values() if joint.age_s is not None]
            newest_ms = min(ages_ms, default=0.0)
            self._unmeasured += len(state.joints) - len(ages_ms)
            self._old += sum(age_ms - newest_ms > PERIOD_S * 1e3 for age_ms in ages_ms)
            self._ages_ms += ages_ms
        return holder is not None

    def figures(self) -> dict[str, Any]:
        """Return what is to be told."""
        slots = sum(max(0, round(error_ms / (PERIOD_S * 1e3))) for error_ms in _gaps_ms(self._measured))
        passed_s = self._measured[-1] - self._measured[0] if len(self._measured) > 1 else nan
        return {
            "states": len(self._measured),
            "states per second": (len(self._measured) - 1) / passed_s,
            "period error of sweeps, ms": _errors(self._measured),
            "period error of states at a client, ms": _errors(self._arrived),
            "cycles without a sweep": slots,
            "sweeps that no state told of": self._lost,
            "states while nothing moved": self._still,
            "motions that ended": self.ended,
            "joints older than a sweep": self._old,
            "share of joints older than a sweep": self._old / max(1, len(self._ages_ms)),
            "age of a joint, ms": _summary(self._ages_ms),
            "joints not measured at all": self._unmeasured,
        }


def stops(robot: Robot, twin: Process, log: Path, ways: dict[str, tuple[float, float]], tries: int) -> dict[str, Any]:
    """Stop again and again while everything moves."""
    _tell(twin, {"faults": FAULTS})
    second = robot.as_owner()
    key = f"{robot.name}/joints/stop"
    held_ms: list[float] = []
    answered_ms: list[float] = []
    failed: list[str] = []
    for _ in range(tries):
        client = Client(robot, ways).start()
        _pass_time(random.uniform(0.3, 0.5))
        began = time.monotonic()
        replies = wire.ask(second, key, {"reason": "bench"}, source="second", timeout_s=2.0)
        answered_ms.append((time.monotonic() - began) * 1e3)
        _pass_time(0.05)
        client.cease()
        _pass_time(WATCH_S)
        at, why = held(goals(log), began, len(ways))
        if why or not replies:
            failed.append(why or "the stop was not answered")
        else:
            held_ms.append((at - began) * 1e3)
    second.close()
    return {
        "stop to held, ms": _summary(held_ms),
        "stop to its answer, ms": _summary(answered_ms),
        "stops": tries,
        "stops held within the target": sum(took_ms <= TARGET_MS for took_ms in held_ms),
        "stops not held": failed,
    }


def held(written: list[tuple[float, dict[int, int]]], began: float, servos: int) -> tuple[float, str]:
    """Return when the last servo was told where to stay; or why that cannot be said."""
    said: dict[int, list[tuple[float, int]]] = {}
    for at, told in written:
        if began <= at <= began + WATCH_S:
            for servo, goal in told.items():
                said.setdefault(servo, []).append((at, goal))
    if len(said) < servos:
        return nan, f"{servos - len(said)} servos were told nothing"
    latest = began
    for told_at in said.values():
        last = told_at[-1][1]
        moved = [index for index, (_, goal) in enumerate(told_at) if abs(goal - last) > HELD_STEPS]
        latest = max(latest, told_at[moved[-1] + 1 if moved else 0][0])
    return latest, "" if latest - began < WATCH_S / 2 else "goals still changed"


def goals(log: Path) -> list[tuple[float, dict[int, int]]]:
    """Return when goals crossed the line, and which."""
    found = []
    for line in log.read_text().splitlines():
        at, code, parameters = line.split()
        data = bytes.fromhex(parameters)
        if code == SYNC_WRITE and data[0] == GOAL:
            size = data[1] + 1
            blocks = [data[first : first + size] for first in range(2, len(data), size)]
            found.append((float(at), {block[0]: block[1] | block[2] << 8 for block in blocks}))
    return found


def _way(lower: float, upper: float) -> tuple[float, float]:
    """Return the middle of a joint's way and how far it goes to each side."""
    lower, upper = max(lower, -MOST_RAD), min(upper, MOST_RAD)
    return (lower + upper) / 2, (upper - lower) * 0.45


def _saw(phase: float) -> float:
    """Return a triangle of slope 1 between -1 and 1."""
    return abs((phase + 1.0) % 4.0 - 2.0) - 1.0


def _switch_on(robot: Robot) -> None:
    said: list[Any] = []

    def on() -> bool:
        said.append(robot.ask("joints/torque", {"on": True}, source="bench"))
        joints = (robot.ask("joints/state") or {}).get("joints", {})
        return len(joints) == 18 and all(joint["torque"] for joint in joints.values())

    try:
        until(on, limit_s=20.0)
    except AssertionError as err:
        raise AssertionError(f"{err}; torque: {said[-1]}; {robot.ask('joints/state')}") from err


def _spent_s(robot: Robot) -> dict[str, float]:
    """Return how much processor time the two processes have had."""
    times = {name: psutil.Process(robot.capability(name)["pid"]).cpu_times() for name in ("servos", "joints")}
    return {name: found.user + found.system for name, found in times.items()}


def _tell(twin: Process, order: dict[str, Any]) -> None:
    twin.tell(json.dumps(order))
    twin.answer()


def _pass_time(seconds: float) -> None:
    threading.Event().wait(seconds)


def _gaps_ms(times: list[float]) -> list[float]:
    return [(later - earlier - PERIOD_S) * 1e3 for earlier, later in pairwise(times)]


def _errors(times: list[float]) -> dict[str, float]:
    return _summary([abs(error_ms) for error_ms in _gaps_ms(times)])


def _summary(samples: list[float]) -> dict[str, float]:
    return {which: round(percentile(samples, which), 3) for which in ("p50", "p99", "max")}


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{name} {number:g}" for name, number in value.items())
    return f"{value:.4g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    sys.exit(main())
