"""Docking by its table in the simulated world, in lockstep: from random places in the room, and with faults.

`python -m benchmarks docking --trials 200 --seed 1 --faults 6`. Exit code 1 if a trial does not dock, touches something
at more than walking pace, or a fault ends unsafely. A safe end: the table is over, the robot stands, and "docked" is
true only if it charges. Drive, beacon, behaviours, battery and odometry are the robot's own, as in `lbr behaviour try
dock`; the drivers' measurements are simulated. After the first trial the compass is wrong by up to 20 degrees.
"""

import argparse
import tempfile
import time
from pathlib import Path
from statistics import median

from benchmarks import Measured
from lbr.apps.behaviours.commands.trials import setup_of
from lbr.commands.rows import opened
from lbr.messages.behaviour import BehaviourRow, BehaviourTable
from lbr.simulation.trials.faults import DOCKING
from lbr.simulation.trials.trial import WALKING_MPS, Outcome, Setup
from lbr.simulation.trials.trying import tried
from tests.support.figures import Promise, Results
from tests.support.robot import prepare

SMOKE = "--trials 1 --faults 0"
PROMISED_S, LONGEST_S, ENDS_S = 120.0, 900.0, 1200.0
"""The table stops its search for the dock after 700 s; its last manoeuvre may then take some minutes."""
PROMISES = {
    "docked": Promise(what="docks and charges, from wherever it is put in the room"),
    "docked in": Promise(
        what="from there until it charges", unit="s", target=PROMISED_S, statistic="p95", hard=LONGEST_S
    ),
    "contact": Promise(what="how fast it comes against anything", unit="m/s", hard=WALKING_MPS),
    "fault": Promise(what="a fault ends safely: it stands, and says that it docked only where it charges"),
}


def options(parser: argparse.ArgumentParser) -> None:
    """Add the amount."""
    parser.add_argument("--trials", type=int, default=20, help="places to begin at (default %(default)s)")
    parser.add_argument(
        "--faults", type=int, default=1, help="places to begin at with each fault (default %(default)s)"
    )
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Dock from each place, then with each fault."""
    results, text, took = Results(PROMISES), [], []
    trials = [(number, "") for number in range(given.trials)]
    trials += [(number, name) for name in DOCKING for number in range(given.faults)]
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        found = sorted(
            tried(_setup(Path(place) / "h"), trials, seed=given.seed), key=lambda one: (one.fault, one.number)
        )
    took_s = time.monotonic() - began
    for one in found:
        results.sample("contact", one.contact_mps)
        if one.fault:
            results.check("fault", [f"{one.fault}, trial {one.number}: {wrong}" for wrong in _wrong(one)])
            text.append(f"{one.fault}: {'; '.join(_wrong(one)) or 'safe'}, in {one.took_s:5.1f} s; {one.text}")
            continue
        good = one.good and one.charging and not _wrong(one)
        results.check("docked", [] if good else [f"trial {one.number} from {one.place}: {one.text} in '{one.state}'"])
        if good:
            took.append(one.took_s)
            results.sample("docked in", one.took_s)
        text.append(f"from {one.place}: {'docked' if good else 'FAILED'} in {one.took_s:5.1f} s; {one.text}")
    if took:
        text.append(f"{len(took)} of {given.trials} docked, half of them within {median(took):.0f} s")
    robot_s = sum(one.took_s for one in found)
    text.append(f"{robot_s:.0f} s of the robot's time in {took_s:.0f} s, {robot_s / took_s:.0f} times as fast as real")
    return Measured(results=results.ordered(), load="lockstep, faster than real time", text="\n".join(text))


def _setup(home: Path) -> Setup:
    with opened(prepare(home, whole=True) / "robot.db") as database:
        rows = database.load("lbr")
    table = next(one for one in rows.of(BehaviourTable) if one.name == "dock")
    lines = tuple(one for one in rows.of(BehaviourRow) if one.behaviour == table.name)
    return setup_of(rows, table, lines, ENDS_S, str(home))


def _wrong(one: Outcome) -> list[str]:
    """Return the violations of safety at the end of a trial."""
    wrong = list(one.unsafe)
    if one.code == "time_over":
        wrong.append(one.text)
    elif one.good and not one.charging:
        wrong.append("it says that it docked, and is not charged")
    return wrong
