"""Plays the motions of the emulated UXA-90 on its body, from standing straight and from the walking stance.

`python -m benchmarks.uxa90` plays all that are shipped, the numbers after it only these. Exit code 1 if it fell.
`--write` makes `firmware.json` anew from `choreography.py` before.
"""

import argparse
import json
import sys
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from typing import Any

from lbr.messages.simulation import HumanoidPose
from lbr.simulation.uxa90 import firmware
from lbr.simulation.uxa90.firmware import Frame, Programme
from tests.models.uxa90.choreography import programmes
from tests.models.uxa90.robot import Robot

FILE = Path(firmware.__file__).with_name("firmware.json")
STAND, BASIC, SIT = 7, 1, 21


def main() -> int:
    """Write if asked to, play, print, and say whether it fell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("slots", nargs="*", type=int, help="motions by slot (default: all)")
    parser.add_argument("--write", action="store_true", help="make firmware.json anew")
    arguments = parser.parse_args()
    if arguments.write:
        FILE.write_text(written(programmes()))
        firmware.shipped.cache_clear()
    slots = arguments.slots or sorted(firmware.shipped())
    played = [play(slot, begin) for slot in slots for begin in (STAND, BASIC)]
    return 0 if all(played) else 1


def play(slot: int, begin: int) -> bool:
    """Play a motion after another, print what became of it, and say whether the robot is on its feet."""
    robot = Robot()
    before = robot.play(STAND)
    if begin != STAND:
        before = robot.play(begin)
    after = robot.play(slot)
    lean = [max(abs(angle) for angle in angles) for angles in _leans(robot.seen)]
    programme = robot.board.programmes[slot]
    print(
        f"{slot:2} {programme.name:20} {programme.duration_s:5.1f} s  from {'straight' if begin == STAND else 'basic   '}"
        f"  {'FELL' if not after.upright else 'stands' if after.stands else 'sits  '}"
        f"  ahead {after.x_m - before.x_m:+.3f} m  left {after.y_m - before.y_m:+.3f} m"
        f"  turned {after.yaw_rad - before.yaw_rad:+.2f} rad  at most rolled {lean[0]:.2f}, pitched {lean[1]:.2f} rad"
        f"  feet lifted {_lifted(robot.seen, 'left_foot')}, {_lifted(robot.seen, 'right_foot')} times"
    )
    return after.upright and after.stands == (slot != SIT)


def written(all_of_them: dict[int, Programme]) -> str:
    """Return the text of `firmware.json`, a frame a line, naming only servos that have something new to do."""
    return "{\n" + ",\n".join(f'  "{slot}": {_programme(each)}' for slot, each in sorted(all_of_them.items())) + "\n}\n"


def _programme(programme: Programme) -> str:
    fields = {"name": programme.name, "limp": programme.limp} if programme.limp else {"name": programme.name}
    text = json.dumps(fields)[:-1] + f', "frames": [{_lines(programme.frames, 4)}]'
    if programme.figures:
        figures = (f'\n    "{name}": [{_lines(frames, 6)}]' for name, frames in programme.figures.items())
        text += f',\n   "figures": {{{",".join(figures)}}}'
    return text + "}"


def _lines(frames: Iterable[Frame], indent: int) -> str:
    out: list[dict[str, Any]] = []
    told: dict[str, float] = {}
    for frame in frames:
        counts = {servo: int(count) if count == int(count) else count for servo, count in frame.counts.items()}
        new: dict[str, Any] = {"duration_s": round(frame.duration_s, 6)}
        new |= {"counts": changed} if (changed := {k: v for k, v in counts.items() if told.get(k) != v}) else {}
        new |= {"smooth": True} if frame.smooth else {}
        told = {} if frame.figure else told | counts
        out.append({"figure": frame.figure, "times": frame.times} if frame.figure else new)
    return ",".join(f"\n{' ' * indent}{json.dumps(line)}" for line in out)


def _leans(seen: list[HumanoidPose]) -> tuple[list[float], list[float]]:
    return [pose.roll_rad for pose in seen], [pose.pitch_rad for pose in seen]


def _lifted(seen: list[HumanoidPose], foot: str) -> int:
    return sum(foot in a.on_floor and foot not in b.on_floor for a, b in pairwise(seen))


if __name__ == "__main__":
    sys.exit(main())
