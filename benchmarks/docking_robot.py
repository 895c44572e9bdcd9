"""Docking with the whole robot in the simulated world, and its motion after the process that moves it dies.

`python -m benchmarks docking_robot --trials 3 --start 2.0 -1.5 160 --anywhere 20`. Exit code 1 if a trial does not dock
within two minutes (five from another place than the world's start). The same if the base still moves 1.5 s after the
process of the table or of the manoeuvre was killed or ended.
"""

import argparse
import json
import math
import os
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks import Measured, listed
from lbr.simulation.settings import WorldSettings
from lbr.simulation.trials.places import starts
from tests.support.figures import Promise, Results
from tests.support.robot import Robot, prepare, running
from tests.support.waiting import until

SMOKE = "--trials 0 --ends SIGKILL"
PROMISES = {
    "docks": Promise(what="the whole robot docks and charges, in two minutes from its start, in five from elsewhere"),
    "stands": Promise(what="1.5 s after the table's or the manoeuvre's process was ended in mid-motion nothing moves"),
}

NEEDED = ("imu", "attitude", "odometry", "battery", "dock", "beacon", "behaviour")
WITHIN_S, ANYWHERE_S, STILL_S = 120.0, 300.0, 1.5
MOVING_MPS, MOVING_RPS = 0.03, 0.1
STANDS_S = 0.3


def options(parser: argparse.ArgumentParser) -> None:
    """Add the number, and the start."""
    parser.add_argument("--trials", type=int, default=1, help="times it docks (default %(default)s)")
    parser.add_argument(
        "--anywhere", type=int, default=0, help="times it docks from seeded places of the room (default %(default)s)"
    )
    parser.add_argument("--seed", type=int, default=1, help="of those places (default %(default)s)")
    parser.add_argument("--start", type=float, nargs=3, metavar=("X", "Y", "DEG"), help="where the robot begins")
    parser.add_argument(
        "--ends", type=listed, default=["SIGKILL", "SIGTERM"], help="what ends them while it moves (default: both)"
    )


def measure(given: argparse.Namespace) -> Measured:
    """Dock, then end the moving process meanwhile."""
    results, text = Results(PROMISES), []
    edits = (begun_at(*given.start),) if given.start else ()
    places = [
        (begun_at(one.x_m, one.y_m, math.degrees(one.yaw_rad)),)
        for one in starts(WorldSettings(), given.anywhere + 1, given.seed)[1:]
    ]
    trials: list[tuple[str, tuple[str, ...], Callable[[Path], tuple[bool, str]]]] = [
        *[("docks", edits, partial(docks, within_s=ANYWHERE_S if given.start else WITHIN_S))] * given.trials,
        *[("docks", place, partial(docks, within_s=ANYWHERE_S)) for place in places],
        *[
            ("stands", edits, partial(dies, number=signal.Signals[name], whose=whose))
            for name in given.ends
            for whose in ("behaviour", "beacon")
        ],
    ]
    for figure, changes, run in trials:
        with tempfile.TemporaryDirectory(prefix="lbr-") as place:
            good, said_so = run(prepare(Path(place) / "h", *NEEDED, edits=changes))
        results.check(figure, [] if good else [said_so])
        text.append(f"{figure}: {'good' if good else 'FAILED'}: {said_so}")
        print(text[-1], file=sys.stderr, flush=True)
    return Measured(results=results.ordered())


def pose(robot: Robot) -> dict[str, Any]:
    """Return the truth about the robot."""
    return dict(until(lambda: robot.ask("world/pose"), what="the robot's pose"))


def moves(robot: Robot) -> bool:
    now = pose(robot)
    return bool(abs(now["speed_mps"]) > MOVING_MPS or abs(now["turn_rps"]) > MOVING_RPS)


def started(robot: Robot) -> int:
    """Start the program and return its process id."""
    text = robot.line("autodock")["text"]
    return int(text.split("(pid ")[1].split(")")[0])


def said(robot: Robot) -> str:
    lines = (robot.home / "logs" / "autodock.log").read_text().splitlines()
    return lines[-1] if lines else ""


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def docks(home: Path, within_s: float) -> tuple[bool, str]:
    """Dock from the robot's start."""
    with running(home, limit_s=30.0) as robot:
        pid, began = started(robot), time.monotonic()
        while alive(pid) and time.monotonic() - began < 2 * within_s:
            time.sleep(0.5)
        took_s, there = time.monotonic() - began, pose(robot)
        good = bool(there["charging"]) and not alive(pid) and took_s < within_s
        battery = robot.ask("battery/state")
        return good, f"{took_s:.0f} s, charging {there['charging']}, battery {battery['charging']}; {said(robot)}"


def dies(home: Path, number: int, whose: str) -> tuple[bool, str]:
    """End a process of the robot while it moves the robot."""
    with running(home, limit_s=30.0) as robot:
        pid, end = started(robot), time.monotonic() + 60.0
        while not moves(robot):
            if time.monotonic() > end or not alive(pid):
                return False, f"it never moved; {said(robot)}"
            time.sleep(0.02)
        os.kill(int(robot.capability(whose)["pid"]), number)
        at = time.monotonic()
        last = at
        while time.monotonic() < at + 4.0:
            last = time.monotonic() if moves(robot) else last
            if whose == "beacon" and time.monotonic() - last > STANDS_S:
                break  # once restarted it serves the table, which may go on
            time.sleep(0.01)
        return (
            last - at < STILL_S,
            f"stood {last - at:.2f} s after {signal.Signals(number).name} of {whose}; {said(robot)}",
        )


def begun_at(x_m: float, y_m: float, yaw_deg: float) -> str:
    """Return the edit that sets this start."""
    start = json.dumps({"x_m": x_m, "y_m": y_m, "yaw_rad": math.radians(yaw_deg)})
    return f"UPDATE capability SET settings = json_set(settings, '$.start', json('{start}')) WHERE name = 'world'"
