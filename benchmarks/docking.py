"""Docking in the simulated world, in lockstep: from the start, and from wherever the robot is let go in the room.

`python -m benchmarks docking --trials 50 --seed 1`. Exit code 1 if a trial does not dock. Physics, beams and battery are
the world's; the drive is left out: powers go straight to the wheels, and turns are made by the true angle. After the
first trial the compass is wrong by up to 18 degrees.
"""

import argparse
from math import degrees
from random import Random

from benchmarks import Measured
from lbr.apps.autodock.script import Manner
from tests.models.docking import COMPASS_DEG, PROMISED_S, Trial, starts
from tests.support.figures import Promise, Results

SMOKE = "--trials 1"
PROMISES = {
    "docked": Promise(what="docks and charges, from wherever it is let go in the room"),
    "docked in": Promise(what="from there until it charges", unit="s", hard=PROMISED_S),
}


def options(parser: argparse.ArgumentParser) -> None:
    """Add how much."""
    parser.add_argument("--trials", type=int, default=20, help="places to begin at (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Dock from each place."""
    results, text, charged = Results(PROMISES), [], 0
    for number, start in enumerate(starts(given.trials, given.seed)):
        error_deg = Random(number).uniform(-COMPASS_DEG, COMPASS_DEG) if number else 0.0
        trial = Trial(start, number, error_deg)
        ending = trial.run(Manner())
        pose = trial.engine.pose()
        good = ending.good and pose.charging
        charged += good
        begun = f"from {start.x_m:5.2f} {start.y_m:5.2f} {degrees(start.yaw_rad):5.0f} deg"
        results.check("docked", [] if good else [f"{begun}: {ending.text}"])
        results.sample("docked in", trial.now)
        text.append(
            f"{begun}: {'docked' if good else 'FAILED'} in {trial.now:5.1f} s at {pose.y_m - 1.2:+.3f} m, "
            f"{degrees(pose.yaw_rad):+.1f} deg; {ending.text}"
        )
    text.append(f"{charged} of {given.trials} docked")
    return Measured(results=results.ordered(), load="lockstep, faster than real time", text="\n".join(text))
