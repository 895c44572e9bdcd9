"""Humanoids that fall, and get up by the motions of their rows, as the kernel of the joints operation moves them.

Each begins upright, leaning towards the side on which it is to lie, and really falls, its joints held. Noise is that of `feet`.
"""

import sys
from math import cos, sin
from random import Random

from lbr.messages.joints import KeyFrame
from lbr.simulation.physics import mujoco
from tests.models.feet import Robot
from tests.support.figures import Promise, Results

FALLS = {"face": ("y", 1.1), "back": ("y", -1.1), "right": ("x", 1.1), "left": ("x", -1.1)}
"""About which axis it leans, and by how much; more than any came back from."""
SIDES = {"face": "get_up_face", "back": "get_up_back", "right": "get_up_side", "left": "get_up_side"}
WAYS = {"bioloid": SIDES, "uxa90": SIDES}
LIES_S, STANDS_S = 1.5, 1.5
DROP_M = 0.01


def fallen(robot: str, side: str, seed: int) -> Robot:
    """Return a robot that has fallen on a side, its joints held by the kernel."""
    dice = Random(seed)
    one = Robot(robot, dice, stepping=True)
    engine = one.engine
    axis, lean = FALLS[side]
    half = (lean + dice.gauss(0.0, 0.1)) / 2
    turned = [cos(half), 0.0, 0.0, 0.0]
    turned[1 if axis == "x" else 2] = sin(half)
    engine.put([dice.gauss(0.0, 0.05) for _ in one.rows])
    engine.data.qpos[3:7] = turned
    mujoco.mj_kinematics(engine.body.model, engine.data)
    engine.data.qpos[2] += DROP_M - min(float(engine.data.geom_xpos[at, 2]) for at in engine.body.solid.nonzero()[0])
    mujoco.mj_forward(engine.body.model, engine.data)
    one.begin()
    one.run(LIES_S)
    return one


def frames(one: Robot, name: str) -> tuple[KeyFrame, ...]:
    """Return the key frames of a motion and of what it leads to."""
    motion = one.motions[name]
    return motion.frames + (one.motions[motion.lead_out].frames if motion.lead_out else ())


def gets_up(robot: str, side: str, seed: int, *, mirror: bool = False) -> bool:
    """Say whether it stands, on its feet alone, after it has fallen and played what gets it up."""
    one = fallen(robot, side, seed)
    assert not one.engine.pose().upright, "it has not fallen"
    way = frames(one, WAYS[robot][side])
    one.play(way, sum(frame.duration_s for frame in way) + STANDS_S, mirror=mirror)
    return one.on_feet and one.engine.pose().stands


def measure(n: int, seed: int, only: str = "") -> tuple[Results, str]:
    """Have each robot fall so often on each side, and get up."""
    cases = [(robot, side) for robot, ways in WAYS.items() for side in ways if only in f"{robot} {side}"]
    results = Results(
        {
            f"{robot} {side}": Promise(what=f"{robot}, fallen on its {side}: not got up", unit="%", target=5.0)
            for robot, side in cases
        }
    )
    lines = []
    for robot, side in cases:
        up = sum(gets_up(robot, side, seed * 1000 + at) for at in range(n))
        results.sample(f"{robot} {side}", 100.0 * (n - up) / n)
        lines.append(f"{robot}, fallen on its {side}: got up {up} of {n}")
        print(lines[-1], file=sys.stderr, flush=True)
    return results, "\n".join(lines)
