"""P6 and P7: cold starts, with everything there, with devices missing, taken or wrong."""

import re
import time
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from tests.support.bench import let_go, temporary_home
from tests.support.figures import Results
from tests.support.hosted import Locked, chatterer, controller
from tests.support.robot import Robot, start

HARMLESS = re.compile(rb"|\?[A-Z]+( \d)?|~[A-Z]+( \d)?|\^(RWD|ECHOF|MXMD) \d+|!M 0 0|!G [12] 0")
TROUBLES = ("missing", "busy", "wrong")


def cold_start(results: Results) -> None:
    """From nothing, the database included, to ready; on a simulated robot."""
    with temporary_home() as home:
        (home / "robot.db").unlink()
        started = time.monotonic()
        robot = start(home)
        results.sample("P6", (time.monotonic() - started) * 1000)
        let_go(robot)


def first_bytes(results: Results) -> None:
    """What reaches a controller until all is ready: set-up, questions and zero, nothing else."""
    with temporary_home() as home, controller(home / "tty") as device:
        robot = start(home, profile=_profile(home, str(home / "tty")))
        heard = bytes(device.heard)
        let_go(robot)
    lines = [line.strip() for line in heard.split(b"\r")]
    odd = [f"before ready the controller heard {line!r}" for line in lines if not HARMLESS.fullmatch(line)]
    results.check("P6 bytes", odd if len(lines) > 3 else ["the controller heard nothing"])


def without_device(results: Results, trouble: str) -> None:
    """A controller that is not there, taken by another process, or something else: degraded, and driving refused."""
    with temporary_home() as home:
        tty = home / "tty"
        place: Any = {"missing": nullcontext(), "busy": Locked(tty), "wrong": chatterer(tty)}[trouble]
        with place:
            started = time.monotonic()
            robot = start(home, profile=_profile(home, str(tty)))
            results.sample("P7", (time.monotonic() - started) * 1000)
            results.check("P7", _not_told(robot, trouble))
            let_go(robot)


def starts(results: Results, n: int) -> None:
    """P6."""
    for _ in range(n):
        cold_start(results)
        first_bytes(results)


def hardware(results: Results, n: int) -> None:
    """P7."""
    for _ in range(n):
        for trouble in TROUBLES:
            without_device(results, trouble)


def _not_told(robot: Robot, trouble: str) -> list[str]:
    units = {unit["name"]: unit for unit in robot.status()["capabilities"]}
    found = [
        f"{trouble}: {name} is {units[name]['phase']} {units[name]['reason']!r}"
        for name, told in (("motors", "motor_controller"), ("ranges", "range_board"))
        if units[name]["phase"] != "degraded" or told not in units[name]["reason"]
    ]
    reply = robot.ask("drive/command", {"power": 0.4, "angle_deg": 0})
    if not reply or reply["accepted"] or "motor" not in reply["reason"]:
        found.append(f"{trouble}: driving was answered {reply}")
    return found


def _profile(home: Path, tty: str) -> str:
    path = home / "bench.toml"
    path.write_text(f'robot = "lbr"\n[devices]\nmotor_controller = "{tty}"\nrange_board = "{home}/nothing"\n')
    return str(path)
