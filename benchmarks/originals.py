"""Runs the first lbr's own tables by its state machine on the simulated robot, repeatedly: do they reach their ends?

`python -m benchmarks originals --n 10`. `autodock` runs in a room with walls and dock as its table expects them. Its
back rule permits the robot the same distance to the wall behind the dock as that table.
"""

import argparse
import json
import os
import sys
import tempfile
from pathlib import Path

from benchmarks import Measured
from tests.models.original.machine import Machine, ask
from tests.support.figures import Promise, Results
from tests.support.robot import Robot, prepare, running
from tests.support.waiting import until

SMOKE = "--n 1 --tables pacing"
FOLDER = Path(__file__).parents[1] / "tests" / "models" / "original"
TABLES = {"pacing": ("pacing.csv", "At Ease"), "sensors": ("sensor_testing.csv", "End"), "autodock": ("autodock.states", "Dock Verified")}  # fmt: skip
PROMISES = {name: Promise(what=f"runs of the first lbr's {file} that ended well") for name, (file, _) in TABLES.items()}


def options(parser: argparse.ArgumentParser) -> None:
    """Add the number, and the tables."""
    parser.add_argument("--n", type=int, default=10, help="runs of each table (default %(default)s)")
    parser.add_argument("--tables", default=",".join(TABLES), help="which (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Run each table on a robot of its own."""
    results, text = Results(PROMISES), []
    for name in given.tables.split(","):
        ends = [_end(name) for _ in range(given.n)]
        wrong = [end for end in ends if end != TABLES[name][1]]
        for end in ends:
            results.check(name, [end] if end != TABLES[name][1] else [])
        text.append(f"{name}: {given.n - len(wrong)} of {given.n} {'; '.join(wrong)}")
        print(text[-1], file=sys.stderr, flush=True)
    return Measured(results=results.ordered(), text="\n".join(text))


def _end(name: str) -> str:
    with tempfile.TemporaryDirectory() as folder:
        home = prepare(Path(folder) / "h", edits=_room() if name == "autodock" else (), whole=True)
        with running(home, limit_s=30.0) as robot:
            until(lambda: robot.capability("web_api")["phase"] == "ready", limit_s=20.0)
            port = int(robot.served("web_api").rpartition(":")[2])
            try:
                with (FOLDER / TABLES[name][0]).open() as lines:
                    end = Machine(lines, lambda *asked: ask(port, *asked)).run()
            except (KeyError, TypeError) as err:
                end = f"{type(err).__name__}: {err}"
            return end if end == TABLES[name][1] else f"{end}, after: {_last_motion(robot)}"


def _last_motion(robot: Robot) -> str:
    """Return how the newest motion ended, and the load of the machine."""
    ends = [event["text"] for event in robot.events() if event["kind"] == "holder" and "lost" in event["text"]]
    return f"{ends[-1] if ends else 'no motion'} (load {os.getloadavg()[0]:.0f})"


def _room() -> tuple[str, ...]:
    room = json.loads((FOLDER / "autodock_room.json").read_text())
    patch = "UPDATE capability SET settings = json_patch(settings, '{}') WHERE robot = 'lbr' AND name = '{}'"
    return (
        patch.format(json.dumps(room["world"]), "world"),
        patch.format(json.dumps({"rules": room["rules"]}), "drive"),
    )
