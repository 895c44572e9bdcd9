"""The regularity of commands and measurements of eighteen joints, and the time until a stop is on their wire;
simulated.

`python -m benchmarks joints_cycle [--seconds 600] [--stops 60] [--json FILE]` runs the processes `servos` and `joints`
of the Bioloid on an emulated servo bus of its own process, with a USB2AX and all the line's delays. A client commands
all joints at 100 Hz, and reads every state. Of the answers, 1 % get lost and 1 % have noise before them; a servo is
silent for 1 % of the time. Then, in the same traffic, a second client sends `joints/stop`. The time is until the last
byte that holds the last joint has crossed the line. Exit code 1 if a stop was not within 50 ms, or a joint not held.
"""

import argparse
import json
import random
import sqlite3
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from math import nan
from pathlib import Path
from typing import Any

import psutil

from benchmarks import Measured
from benchmarks.instruments.joints_traffic import Client, Watched, errors, pass_time, summary, way
from lbr.bus import keys, wire
from lbr.database import store
from tests.support.figures import Promise, Results
from tests.support.robot import Robot, start
from tests.support.servo_bus.line import Process
from tests.support.waiting import until

SMOKE = "--seconds 2 --stops 2"

FAULTS = {"drop": 0.01, "garbage": 0.01}
DEAD_EVERY_S, DEAD_S = 30.0, 0.3
HELD_STEPS = 4
"""A smaller change of the goal counts as holding: the goal is a measurement of one sweep earlier or later."""
WATCH_S = 0.3
PROMISES = {"joints stop": Promise(what="stop in full traffic, to the last joint held", target=20.0, hard=50.0)}
SYNC_WRITE, GOAL = "83", 30


def options(parser: argparse.ArgumentParser) -> None:
    """Add the duration, and the number."""
    parser.add_argument(
        "--seconds", type=float, default=600.0, help="how long the cycle is watched (default %(default)s)"
    )
    parser.add_argument("--stops", type=int, default=60, help="stops in the same traffic (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Watch the cycle, then stop in it."""
    results = Results(PROMISES)
    with tempfile.TemporaryDirectory(prefix="lbr-") as place, running(Path(place) / "h") as (robot, twin, log, ways):
        figures = cycle(robot, twin, log, ways, given.seconds)
        figures |= stops(results, robot, twin, log, ways, given.stops)
    return Measured(results=results.ordered(), load=f"{given.seconds:g} s of traffic", figures=figures)


@contextmanager
def running(home: Path) -> Iterator[tuple[Robot, Process, Path, dict[str, tuple[float, float]]]]:
    """Run the two processes on an emulated bus; yield the robot, the bus, its log, and each joint's range."""
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
        sys.executable, "-m", "tests.support.servo_bus.twin", str(home / "run" / "bioloid-devices" / "servo_bus")
    )
    try:
        positions_rad = [zero_rad for _, zero_rad, _, _ in rows]
        order = {"delay": 250, "usb2ax": 5, "usb_us": 250.0, "positions_rad": positions_rad, "log": str(log)}
        _tell(twin, order)
        robot = start(home, profile="bioloid-sim")
        try:
            _switch_on(robot)
            yield robot, twin, log, {name: way(lower, upper) for name, _, lower, upper in rows}
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
    pass_time(1.0)
    states.take()
    begun, spent_s = time.monotonic(), _spent_s(robot)
    found = Watched()
    dead_at = begun + min(DEAD_EVERY_S, seconds) / 2
    while (now := time.monotonic()) < begun + seconds:
        if now >= dead_at:
            _tell(twin, {"faults": {**FAULTS, "silent": [random.randint(1, len(ways))]}})
            pass_time(DEAD_S)
            _tell(twin, {"faults": FAULTS})
            dead_at += DEAD_EVERY_S
        pass_time(0.05)
        if not found.take(states.take()):
            found.ended += client.again()
    shares = {name: (now_s - spent_s[name]) / (now - begun) for name, now_s in _spent_s(robot).items()}
    client.cease()
    states.close()
    written = [at for at, _ in goals(log) if begun <= at < begun + seconds]
    return {
        **found.figures(),
        "period error of goals on the wire, ms": errors(written),
        "motions refused, by reason": dict(client.refused.most_common(8)),
        "commands sent late, ms": summary(client.late_ms),
        "share of a core": {name: round(share, 3) for name, share in shares.items()},
    }


def stops(
    results: Results, robot: Robot, twin: Process, log: Path, ways: dict[str, tuple[float, float]], tries: int
) -> dict[str, Any]:
    """Stop repeatedly while everything moves."""
    _tell(twin, {"faults": FAULTS})
    second = robot.as_owner()
    key = f"{robot.name}/joints/stop"
    answered_ms: list[float] = []
    for _ in range(tries):
        client = Client(robot, ways).start()
        pass_time(random.uniform(0.3, 0.5))
        began = time.monotonic()
        replies = wire.ask(second, key, {"reason": "bench"}, source="second", timeout_s=2.0)
        answered_ms.append((time.monotonic() - began) * 1e3)
        pass_time(0.05)
        client.cease()
        pass_time(WATCH_S)
        at, why = held(goals(log), began, len(ways))
        results.check("joints stop", [why or "the stop was not answered"] if why or not replies else [])
        if not why and replies:
            results.sample("joints stop", (at - began) * 1e3)
    second.close()
    return {"stop to its answer, ms": summary(answered_ms)}


def held(written: list[tuple[float, dict[int, int]]], began: float, servos: int) -> tuple[float, str]:
    """Return when the last servo got its holding goal; or why that is unknown."""
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
    """Return the goals on the line, with their times."""
    found = []
    for line in log.read_text().splitlines():
        at, code, parameters = line.split()
        data = bytes.fromhex(parameters)
        if code == SYNC_WRITE and data[0] == GOAL:
            size = data[1] + 1
            blocks = [data[first : first + size] for first in range(2, len(data), size)]
            found.append((float(at), {block[0]: block[1] | block[2] << 8 for block in blocks}))
    return found


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
    """Return the processor time of each process so far."""
    units = [robot.capability(name) for name in ("servos", "joints")]
    times = {unit["process"] or unit["name"]: psutil.Process(unit["pid"]).cpu_times() for unit in units}
    return {name: found.user + found.system for name, found in times.items()}


def _tell(twin: Process, order: dict[str, Any]) -> None:
    twin.tell(json.dumps(order))
    twin.answer()
