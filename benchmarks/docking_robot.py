"""Docking with the whole robot in the simulated world, and what is left of its motion when its program dies.

`python -m benchmarks.docking_robot --trials 3 --start 2.0 -1.5 160`. Exit code 1 if a trial does not dock within
two minutes (five from another place than the world's own start), or if the base
still moves 1.5 s after the program was killed or ended.
"""

import argparse
import json
import math
import os
import signal
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from tests.support.robot import Robot, prepare, running

NEEDED = ("imu", "attitude", "odometry", "battery", "dock")
WITHIN_S, ANYWHERE_S, STILL_S = 120.0, 300.0, 1.5
MOVING_MPS, MOVING_RPS = 0.03, 0.1


def pose(robot: Robot) -> dict[str, Any]:
    """The truth about the robot."""
    return robot.ask("world/pose")


def moves(robot: Robot) -> bool:
    now = pose(robot)
    return abs(now["speed_mps"]) > MOVING_MPS or abs(now["turn_rps"]) > MOVING_RPS


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
    """Dock from where the robot begins."""
    with running(home, limit_s=30.0) as robot:
        pid, began = started(robot), time.monotonic()
        while alive(pid) and time.monotonic() - began < 2 * within_s:
            time.sleep(0.5)
        took_s, there = time.monotonic() - began, pose(robot)
        good = bool(there["charging"]) and not alive(pid) and took_s < within_s
        battery = robot.ask("battery/state")
        return good, f"{took_s:.0f} s, charging {there['charging']}, battery {battery['charging']}; {said(robot)}"


def dies(home: Path, number: int) -> tuple[bool, str]:
    """End the program while the robot moves."""
    with running(home, limit_s=30.0) as robot:
        pid, until = started(robot), time.monotonic() + 60.0
        while not moves(robot):
            if time.monotonic() > until or not alive(pid):
                return False, f"it never moved; {said(robot)}"
            time.sleep(0.02)
        os.kill(pid, number)
        at = time.monotonic()
        last = at
        while time.monotonic() < at + 4.0:
            last = time.monotonic() if moves(robot) else last
            time.sleep(0.01)
        return last - at < STILL_S, f"stood {last - at:.2f} s after {signal.Signals(number).name}; {said(robot)}"


def begun_at(x_m: float, y_m: float, yaw_deg: float) -> str:
    """Return the edit that puts the robot there at the beginning."""
    start = json.dumps({"x_m": x_m, "y_m": y_m, "yaw_rad": math.radians(yaw_deg)})
    return f"UPDATE capability SET settings = json_set(settings, '$.start', json('{start}')) WHERE name = 'world'"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=1)
    parser.add_argument("--start", type=float, nargs=3, metavar=("X", "Y", "DEG"), help="where the robot begins")
    given = parser.parse_args()
    edits = (begun_at(*given.start),) if given.start else ()
    trials = [("docks", docks, (ANYWHERE_S if given.start else WITHIN_S,))] * given.trials
    trials += [("dies", dies, (signal.SIGKILL,)), ("ends", dies, (signal.SIGTERM,))]
    failed = 0
    for name, run, arguments in trials:
        with tempfile.TemporaryDirectory(prefix="lbr-") as place:
            good, text = run(prepare(Path(place) / "h", *NEEDED, edits=edits), *arguments)
        failed += not good
        print(f"{name}: {'good' if good else 'FAILED'}: {text}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
