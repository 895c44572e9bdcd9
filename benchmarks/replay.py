"""Measures whether a recording with lines gives the same result when it runs again through the real drivers, on three
robots.

`python -m benchmarks replay --n 20 --robots lbr,bioloid,uxa90`. Each try records a robot with random actions, and
checks that recording. Exit code 1 if one of them differs.
"""

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import msgspec

from benchmarks import Measured, listed
from lbr import client
from lbr.client.motion import RefusalError
from tests.support import programs
from tests.support.figures import Promise, Results
from tests.support.robot import LBR, Robot, environment, prepare, running

SMOKE = "--n 1 --robots lbr --seconds 4"
PROMISES = {
    f"RP {name}": Promise(what=f"runs of {name} whose setpoints, answers and reasons were not as recorded", hard=0)
    for name in ("lbr", "bioloid", "uxa90")
}
ALSO = ("imu", "attitude", "odometry", "battery", "dock", "beacon", "behaviour", "box")
MOTIONS = {
    "bioloid": ("wave", "ready", "sit", "stand_up"),
    "uxa90": ("reset", "basic_motion", "kick_right", "turn_left"),
}


def options(parser: argparse.ArgumentParser) -> None:
    """Add the number, and the robots."""
    parser.add_argument("--n", type=int, default=20, help="recordings of each robot (default %(default)s)")
    parser.add_argument("--seconds", type=float, default=8.0, help="of each recording (default %(default)s)")
    parser.add_argument("--robots", type=listed, default=["lbr", "bioloid", "uxa90"], metavar="lbr,bioloid,uxa90")
    parser.add_argument("--seed", type=int, default=1, help="of chance (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Record, and check."""
    results, text = Results(PROMISES), []
    for name in given.robots:
        same, first, samples, commands = 0, 0, 0, 0
        with tempfile.TemporaryDirectory(prefix="lbr-") as place:
            home = prepare(Path(place) / "h", *ALSO)
            os.environ["LBR_HOME"] = str(home)
            made = []
            for number in range(given.n):
                with running(home, profile=f"{name}-sim", limit_s=60.0) as robot:
                    made.append(_recorded(robot, f"r{number}", given.seconds, random.Random(f"{given.seed} {number}")))
            for one in made:
                found = _checked(home, one)
                wrong = "" if found.get("same") else _why(found)
                results.check(f"RP {name}", [f"{one}: {wrong}"] if wrong else [])
                same += not wrong
                first += not wrong and found["tries"] == 1
                samples += sum(each["samples"] for each in found.get("setpoints", {}).values())
                commands += found.get("commands", {}).get("said", 0)
                print(f"{name} {one}: {wrong or 'as recorded'} ({found.get('tries')})", file=sys.stderr, flush=True)
        text.append(
            f"{name}: {same} of {given.n} as recorded, {first} at the first try; {samples} samples of setpoints, {commands} commands compared"
        )
    return Measured(results=results.ordered(), text="\n".join(text))


def _recorded(robot: Robot, name: str, seconds: float, dice: random.Random) -> str:
    command = [*LBR, "record", "--lines", "--name", name]
    with programs.start(
        command, env=environment(robot.home), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as said:
        assert said.stderr is not None
        assert "records" in (line := said.stderr.readline()), line
        time.sleep(1.5)
        with client.connect(robot.name, name="benchmark") as found:
            if robot.name != "lbr":
                found.say("/torque/on")
            until = time.monotonic() + seconds
            while time.monotonic() < until:
                try:
                    _something(found, robot.name, dice)
                except RefusalError as err:
                    print(f"refused: {err}", file=sys.stderr)
                time.sleep(dice.uniform(0.3, 0.8))  # like a person
        time.sleep(0.5)
        said.send_signal(signal.SIGINT)
        said.communicate(timeout=20)
    return name


def _something(found: client.Robot, robot: str, dice: random.Random) -> None:
    if robot == "lbr":
        match dice.randrange(4):
            case 0:
                found.turn(dice.choice([-60, -30, 30, 60, 90]))
            case 1:
                found.say("stop")
            case _:
                with found.drive(dice.uniform(0.1, 0.4), dice.choice([0, 90, 180, 270, 30])):
                    time.sleep(dice.uniform(0.2, 1.2))
        return
    match dice.randrange(3):
        case 0:
            found.say("stop")
        case _:
            found.say(f"/play/{dice.choice(MOTIONS[robot])}", hold_s=dice.uniform(0.5, 4.0))


def _why(found: dict[str, Any]) -> str:
    """Return the difference, in a line."""
    if "error" in found:
        return str(found["error"])
    setpoints = {topic: len(one["differences"]) for topic, one in found["setpoints"].items() if one["differences"]}
    first = [one["differences"][0] for one in found["setpoints"].values() if one["differences"]]
    answers = [
        f"{one['command']} {one['then'].get('code')}, {(one['now'] or {}).get('reason')}"
        for one in found["commands"]["otherwise"]
    ]
    return f"{setpoints} {first[:2]} {answers[:3]} {found['reasons']}"


def _checked(home: Path, name: str) -> dict[str, Any]:
    done = programs.run(
        [*LBR, "replay", name, "--check", "--json"], env=environment(home), capture_output=True, check=False
    )
    try:
        return msgspec.json.decode(done.stdout, type=dict[str, Any])
    except msgspec.DecodeError:
        return {"error": done.stderr.decode(errors="replace")[-300:]}
