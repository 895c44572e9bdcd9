"""Runs `spin` on the model: a search of all its states, or a history drawn by chance."""

import os
import re
import time
from collections.abc import Iterable
from dataclasses import dataclass
from math import ceil, floor
from pathlib import Path
from tempfile import TemporaryDirectory

from lbr.drivers.roboteq import RoboteqSettings
from lbr.leases.lease import LATE_S
from lbr.leases.rules import PERSISTENT_S
from lbr.operations.drive.kernel import first_state
from lbr.operations.drive.settings import DriveSettings
from tests.support import programs

MODEL = Path(__file__).with_name("lease.pml")
FINE_S = 11 / 128
"""A tick short enough that a setpoint lives for two; binary, so that sums of it are exact."""
DRIVE = DriveSettings(max_run_s=3600.0, blocked_s=3600.0, accel_per_s=50.0)
ROBOTEQ = RoboteqSettings(device="motors")
TRACE = "@ "
SHALLOW, DEEP = 20_000, 60_000_000
"""Steps of one history: a seeded error is found soon, and what led to it is replayed; all states take long ones."""
MOST_MEGABYTES = 8000


@dataclass(frozen=True, slots=True)
class Found:
    """What a search came to: how many states, how deep, in what time; `broken` is the property, `trace` how."""

    states: int
    depth: int
    seconds: float
    megabytes: float
    closed: bool
    broken: int = 0
    trace: tuple[str, ...] = ()


def ticks(tick_s: float) -> dict[str, int]:
    """Return lbr's own times in ticks: each is the first tick at which something is over, `LATE` the last it is not."""
    ahead_s = min(first_state(DRIVE).leases.ahead_s, DRIVE.ttl_s / 5)
    over_s = {
        "LEASE": DRIVE.ttl_s - ahead_s,
        "OFFER": DRIVE.ttl_s,
        "INSIST": PERSISTENT_S,
        "VALID": ROBOTEQ.setpoint_valid_s,
        "WATCHDOG": ROBOTEQ.watchdog_ms / 1000,
    }
    return {"LATE": floor(LATE_S / tick_s)} | {name: ceil(limit / tick_s) for name, limit in over_s.items()}


class Search:
    """The model as a program, compiled once in a folder; `quickly`, as its searches will be short."""

    def __init__(self, folder: Path, tick_s: float, *, quickly: bool = False, defines: Iterable[str] = ()) -> None:
        self._folder = folder
        given = [f"-D{name}={value}" for name, value in ticks(tick_s).items()]
        _run(["spin", "-a", "-DCHOSEN", *given, *defines, str(MODEL)], folder)
        flags = ["-O1" if quickly else "-O2", "-DSAFETY", "-DNOFAIR", f"-DMEMLIM={MOST_MEGABYTES}", "-w"]
        _run(["cc", *flags, "-o", "pan", "pan.c"], folder)

    def run(self, world: str, bug: int = 0, *, depth: int = SHALLOW, hash_bits: int = 20) -> Found:
        """Search all that can happen in a world, or, with a seeded error, until that has broken a property."""
        environment = {**os.environ, "LEASE": f"{world}{bug or ''}"}
        began = time.monotonic()
        argv = ["./pan", f"-w{hash_bits}", f"-m{depth}"]
        said = _run(argv, self._folder, environment)
        seconds = time.monotonic() - began
        trail = next(self._folder.glob("*.trail"), None)
        trace: tuple[str, ...] = ()
        if trail is not None:
            trace = lines(_run(["./pan", "-r", trail.name], self._folder, environment))
            trail.unlink()
        broken = [int(line.split()[1]) for line in trace if line.startswith("violated")]
        return Found(
            states=int(_number(r"([\d.e+]+) states, stored", said)),
            depth=int(_number(r"depth reached (\d+)", said)),
            seconds=seconds,
            megabytes=_number(r"([\d.]+)\s+total actual memory usage", said),
            closed="errors: 0" in said and "Search not completed" not in said and "too small" not in said,
            broken=broken[0] if broken else 0,
            trace=trace,
        )


def by_chance(seed: int, steps: int, tick_s: float, world: str) -> tuple[str, ...]:
    """Return a history that spin draws from a seed."""
    flags = {"REMOTE": "r", "TAKING": "t", "ESTOP": "e", "CRASHES": "c", "INSISTING": "i"}
    chosen = {name: int(letter in world) for name, letter in flags.items()} | ticks(tick_s)
    given = [f"-D{name}={value}" for name, value in chosen.items()]
    argv = ["spin", f"-n{seed}", f"-u{steps}", "-T", "-DWALK", *given, str(MODEL)]
    with TemporaryDirectory() as folder:  # spin leaves a file of one name where it runs, and tests run at once
        return lines(_run(argv, Path(folder)))


def lines(said: str) -> tuple[str, ...]:
    """Return what a history says for a replay."""
    return tuple(line.strip().removeprefix(TRACE) for line in said.splitlines() if line.strip().startswith(TRACE))


def _run(argv: list[str], folder: Path, environment: dict[str, str] | None = None) -> str:
    done = programs.run(argv, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0 and argv[0] != "./pan":
        raise RuntimeError(f"{' '.join(argv)}: {done.stdout}{done.stderr}")
    return done.stdout


def _number(pattern: str, said: str) -> float:
    found = re.search(pattern, said)
    return float(found.group(1)) if found else 0.0
