"""Docking by its table in the simulated world, in lockstep: from wherever the robot is put in the room, and with faults.

`python -m benchmarks docking --trials 50 --seed 1 --faults 3`. Exit code 1 if a trial does not dock, touches something at more
than walking pace, or a fault ends otherwise than safely: the table over, the robot standing, and "docked" only where it
charges. Physics, beams and battery are the world's; the drive is left out: powers go straight to the wheels, and turns are
made by the true angle. After the first trial the compass is wrong by up to 20 degrees.
"""

import argparse
from math import degrees
from random import Random
from statistics import median

from benchmarks import Measured
from tests.models.docking import COMPASS_DEG, FAULTS, PROMISED_S, WALKING_MPS, Trial, safe, starts
from tests.models.table_run import dock_table
from tests.support.figures import Promise, Results

SMOKE = "--trials 1 --faults 0"
PROMISES = {
    "docked": Promise(what="docks and charges, from wherever it is put in the room"),
    "docked in": Promise(what="from there until it charges", unit="s", target=PROMISED_S, statistic="p95", hard=900),
    "contact": Promise(what="how fast it comes against anything", unit="m/s", hard=WALKING_MPS),
    "fault": Promise(what="a fault ends safely: it stands, and says that it docked only where it charges"),
}


def options(parser: argparse.ArgumentParser) -> None:
    """Add how much."""
    parser.add_argument("--trials", type=int, default=20, help="places to begin at (default %(default)s)")
    parser.add_argument(
        "--faults", type=int, default=1, help="places to begin at with each fault (default %(default)s)"
    )
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Dock from each place, then with each fault."""
    results, text, took = Results(PROMISES), [], []
    table = dock_table()
    for number, start in enumerate(starts(given.trials, given.seed)):
        trial = Trial(start, number, _error_deg(number))
        ending, pose = trial.run(table), trial.engine.pose()
        good = ending.good and pose.charging
        begun = f"from {start.x_m:5.2f} {start.y_m:5.2f} {degrees(start.yaw_rad):5.0f} deg"
        results.check("docked", [] if good else [f"{begun}: {ending.text}"])
        results.sample("contact", trial.fastest_mps)
        if good:
            took.append(trial.now)
            results.sample("docked in", trial.now)
        text.append(f"{begun}: {'docked' if good else 'FAILED'} in {trial.now:5.1f} s; {ending.text}")
    for name, faults in FAULTS.items():
        for number, start in enumerate(starts(given.faults, given.seed + 1)):
            trial = Trial(start, number, _error_deg(number), faults)
            ending = trial.run(table)
            wrong = safe(trial, ending)
            results.check("fault", [f"{name}: {one}" for one in wrong])
            results.sample("contact", trial.fastest_mps)
            text.append(f"{name}: {'; '.join(wrong) or 'safe'}, in {trial.now:5.1f} s; {ending.text}")
    if took:
        text.append(f"{len(took)} of {given.trials} docked, half of them within {median(took):.0f} s")
    return Measured(results=results.ordered(), load="lockstep, faster than real time", text="\n".join(text))


def _error_deg(number: int) -> float:
    return Random(number).uniform(-COMPASS_DEG, COMPASS_DEG) if number else 0.0
