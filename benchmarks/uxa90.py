"""Plays the motions of the emulated UXA-90 on its body, from standing straight and from the walking stance.

`python -m benchmarks uxa90` plays all shipped motions, or those of the given numbers. Exit code 1 if it fell.
"""

import argparse
from itertools import pairwise

from benchmarks import Measured
from lbr.robots.uxa90.twin import firmware
from lbr.simulation.messages import HumanoidPose
from tests.models.uxa90.robot import Robot
from tests.support.figures import Promise, Results

SMOKE = "7"
PROMISES = {"motions": Promise(what="motions of the main board after which the emulated UXA-90 is on its feet")}

STAND, BASIC, SIT = 7, 1, 21


def options(parser: argparse.ArgumentParser) -> None:
    """Add the motions."""
    parser.add_argument("slots", nargs="*", type=int, help="motions by slot (default: all)")


def measure(given: argparse.Namespace) -> Measured:
    """Play each, from standing straight and from the walking stance."""
    results, text = Results(PROMISES), []
    for slot in given.slots or sorted(firmware.shipped()):
        for begin in (STAND, BASIC):
            good, said = play(slot, begin)
            text.append(said)
            results.check("motions", [] if good else [said])
    return Measured(results=results.ordered(), load="nothing sleeps", text="\n".join(text))


def play(slot: int, begin: int) -> tuple[bool, str]:
    """Play a motion after another; return whether the robot is on its feet, and the result in words."""
    robot = Robot()
    before = robot.play(STAND)
    if begin != STAND:
        before = robot.play(begin)
    after = robot.play(slot)
    lean = [max(abs(angle) for angle in angles) for angles in _leans(robot.seen)]
    programme = robot.board.programmes[slot]
    said = (
        f"{slot:2} {programme.name:20} {programme.duration_s:5.1f} s  from {'straight' if begin == STAND else 'basic   '}"
        f"  {'FELL' if not after.upright else 'stands' if after.stands else 'sits  '}"
        f"  ahead {after.x_m - before.x_m:+.3f} m  left {after.y_m - before.y_m:+.3f} m"
        f"  turned {after.yaw_rad - before.yaw_rad:+.2f} rad  at most rolled {lean[0]:.2f}, pitched {lean[1]:.2f} rad"
        f"  feet lifted {_lifted(robot.seen, 'left_foot')}, {_lifted(robot.seen, 'right_foot')} times"
    )
    return after.upright and after.stands == (slot != SIT), said


def _leans(seen: list[HumanoidPose]) -> tuple[list[float], list[float]]:
    return [pose.roll_rad for pose in seen], [pose.pitch_rad for pose in seen]


def _lifted(seen: list[HumanoidPose], foot: str) -> int:
    return sum(foot in a.on_floor and foot not in b.on_floor for a, b in pairwise(seen))
