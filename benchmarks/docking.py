"""Docking in the simulated world, in lockstep: from the start, and from wherever the robot is let go in the room.

`python -m benchmarks.docking --trials 50 --seed 1`. Exit code 1 if a trial does not dock. Physics, beams and battery are
the world's; the drive is left out: powers go straight to the wheels, and turns are made by the true angle. After the
first trial the compass is wrong by up to 18 degrees.
"""

import argparse
import sys
from math import degrees
from random import Random

from lbr.apps.autodock.script import Manner
from tests.models.docking import COMPASS_DEG, PROMISED_S, Trial, starts


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    failed, times = 0, []
    for number, start in enumerate(starts(given.trials, given.seed)):
        error_deg = Random(number).uniform(-COMPASS_DEG, COMPASS_DEG) if number else 0.0
        trial = Trial(start, number, error_deg)
        ending = trial.run(Manner())
        pose = trial.engine.pose()
        good = ending.good and pose.charging
        failed += not good
        times.append(trial.now)
        print(
            f"from {start.x_m:5.2f} {start.y_m:5.2f} {degrees(start.yaw_rad):5.0f} deg: "
            f"{'docked' if good else 'FAILED'} in {trial.now:5.1f} s at {pose.y_m - 1.2:+.3f} m, "
            f"{degrees(pose.yaw_rad):+.1f} deg; {ending.text}"
        )
    times.sort()
    print(
        f"{len(times) - failed} of {len(times)} docked; median {times[len(times) // 2]:.0f} s, longest {times[-1]:.0f} s"
    )
    return 1 if failed or times[-1] > PROMISED_S else 0


if __name__ == "__main__":
    sys.exit(main())
