"""Measures how near to the requested range the base comes to rest: in lockstep, and with the whole robot.

`python -m benchmarks ranges --rounds 4 --stops 20`. Between two walls, ahead and back, by the sonar that leads and by the
one that follows. Exit code 1 if a move to a range did not end reached.
"""

import argparse
import json
import sys
import tempfile
import time
from itertools import cycle, islice
from pathlib import Path

import msgspec

from benchmarks import Measured
from tests.models import ranging
from tests.models.ranging import PROMISES, STOPS, Stop
from tests.support.figures import Promise, Results
from tests.support.robot import Robot, prepare, running
from tests.support.waiting import until

SMOKE = "--rounds 0 --stops 1"
ROBOT = {
    "R1 robot": Promise(what="from the range that was asked for, the whole robot rests", unit="cm", target=0.5, statistic="p50"),
    "R1 robot p95": Promise(what="the same", unit="cm", target=ranging.NEAR_CM, statistic="p95"),
    "R2 robot": Promise(what="every move of the whole robot to a range ends reached"),
}  # fmt: skip
POWER, RENEW_S, LEASE_S = 0.25, 0.1, 1.0
STANDS_MPS = 1e-3


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount."""
    parser.add_argument(
        "--rounds", type=int, default=4, help="of all stops and powers in lockstep (default %(default)s)"
    )
    parser.add_argument("--stops", type=int, default=20, help="of the whole robot (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Stop at ranges."""
    results, text = Results(PROMISES | ROBOT), []
    for stop, power, off_cm in ranging.measure(results, given.rounds, given.seed):
        if abs(off_cm) > ranging.NEAR_CM:
            text.append(f"lockstep: {stop} at power {power:g}: {off_cm:+.1f} cm")
    if given.stops:
        with tempfile.TemporaryDirectory(prefix="lbr-") as place:
            home = prepare(Path(place) / "h", edits=(_walls(given.seed),), whole=True)
            with running(home) as robot:
                for stop in islice(cycle(STOPS), given.stops):
                    text.append(_stopped(robot, stop, results))
                    print(text[-1], file=sys.stderr, flush=True)
    return Measured(results=results.ordered(), text="\n".join(text))


def _stopped(robot: Robot, stop: Stop, results: Results) -> str:
    command = {"power": POWER, "angle_deg": stop.angle_deg, "range_cm": stop.range_cm, "sensor": stop.sensor}
    since = time.monotonic()
    reply = robot.ask("drive/command", {**command, "ttl_s": LEASE_S})
    lease = reply["lease"]
    while reply["accepted"]:
        time.sleep(RENEW_S)
        reply = robot.ask("drive/command", {**command, "lease": lease, "ttl_s": LEASE_S})
    took_s = time.monotonic() - since
    until(lambda: abs(robot.ask("world/pose")["speed_mps"]) < STANDS_MPS, what="the robot stands")
    off_cm = ranging.true_cm(stop.sensor, robot.ask("world/pose")["x_m"]) - stop.range_cm
    results.check("R2 robot", [] if reply.get("cause") == "done" else [f"{stop}: {reply['reason']}"])
    results.sample("R1 robot", abs(off_cm))
    results.sample("R1 robot p95", abs(off_cm))
    return f"robot: {stop}: {off_cm:+.1f} cm in {took_s:.1f} s"


def _walls(seed: int) -> str:
    changes = json.dumps({"walls": msgspec.to_builtins(ranging.WALLS), "dock": None, "seed": seed})
    return f"UPDATE capability SET settings = json_patch(settings, '{changes}') WHERE robot = 'lbr' AND name = 'world'"
