"""Shows each joint's angle, and the least and the most that it was: to learn a humanoid's signs and limits by hand.

lbr topic echo joints/state --json | python docs/examples/joint_angles.py
"""

import contextlib
import json
import sys
from math import degrees

HOME = "\x1b[H\x1b[J"
EVERY = 10  # of about 100 states a second


def main() -> None:
    least: dict[str, float] = {}
    most: dict[str, float] = {}
    for number, line in enumerate(sys.stdin):
        joints = json.loads(line)["joints"]
        rows = [
            f"{'joint':24}{'id':>4}{'raw':>6}{'degrees':>9}{'least':>9}{'most':>9}{'least rad':>11}{'most rad':>10}"
        ]
        for name, joint in sorted(joints.items(), key=lambda item: item[1]["id"]):
            angle = joint["position_rad"]
            if angle is None:
                rows.append(f"{name:24}{joint['id']:>4}  {joint['reason']}")
                continue
            least[name], most[name] = min(angle, least.get(name, angle)), max(angle, most.get(name, angle))
            low, high = least[name], most[name]
            shown = f"{degrees(angle):>9.1f}{degrees(low):>9.1f}{degrees(high):>9.1f}{low:>11.3f}{high:>10.3f}"
            rows.append(f"{name:24}{joint['id']:>4}{joint['raw']:>6}{shown}")
        if number % EVERY == 0:
            print((HOME if sys.stdout.isatty() else "") + "\n".join(rows), flush=True)


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()
