"""The rows' humanoid in the engine, and its motions played there as the rows write them."""

import json
import sqlite3
from functools import cache
from itertools import pairwise
from math import radians

from lbr.messages.joints import Joint, KeyFrame, Motion
from lbr.operations.joints.trajectory import plan, positions
from lbr.simulation.humanoid.engine import HumanoidEngine
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from lbr.simulation.measured import ServoDrive
from tests.support import shipped

TICK_S = 0.01
STEP_RAD = radians(300.0 / 1023.0)


@cache
def rows():
    """The joints and the motions by name."""
    database = sqlite3.connect(":memory:")
    database.executescript(shipped.sql())
    fields = ("name", "device_id", "side", "sign", "zero_rad", "lower_rad", "upper_rad", "speed_rps")
    found = database.execute(f"SELECT {', '.join(fields)} FROM joint WHERE robot = 'bioloid' ORDER BY device_id")
    joints = tuple(Joint(**dict(zip(fields, row, strict=True))) for row in found)
    steps = database.execute(
        "SELECT motion, duration_s, positions FROM motion_step WHERE robot = 'bioloid' ORDER BY motion, step"
    ).fetchall()
    motions = {}
    for name, lead_in, lead_out in database.execute(
        "SELECT name, lead_in, lead_out FROM motion WHERE robot = 'bioloid'"
    ):
        frames = (KeyFrame(positions=json.loads(to), duration_s=took) for motion, took, to in steps if motion == name)
        motions[name] = Motion(name=name, frames=tuple(frames), lead_in=lead_in, lead_out=lead_out)
    return joints, motions


def humanoid(home="/nonexistent", **settings):
    """An engine with the shipped body."""
    return HumanoidEngine(HumanoidWorldSettings(**{"model": "bioloid", **settings}), rows()[0], home)


def drives(pose, torque=1.0, **more):
    """Servos driven to the angles of joints; a joint left out goes to zero."""
    return {
        joint.device_id: ServoDrive(
            goal_rad=stepped(joint.zero_rad + joint.sign * pose.get(joint.name, 0.0)), torque=torque, **more
        )
        for joint in rows()[0]
    }


def stepped(servo_rad):
    """The nearest angle that a servo can be told."""
    return round(servo_rad / STEP_RAD) * STEP_RAD


class Player:
    """Plays key frames on a robot that stands by itself, and remembers what a bystander saw."""

    def __init__(self, engine=None):
        self.engine = engine or humanoid(hand_s=0.1)
        self.goal = {joint.name: 0.0 for joint in rows()[0]}
        self.seen = []
        self.go((), hold_s=0.4)

    def play(self, name, times=1, interpolation="smooth"):
        """Play a motion of the rows with its lead-in and lead-out, then stand for a while."""
        motion = rows()[1][name]
        self.go(frames_of(motion, times), interpolation=interpolation, hold_s=1.0)
        return self.engine.pose()

    def go(self, frames, *, interpolation="smooth", until_share=1.0, hold_s=0.0):
        """Go through key frames, or a share of the way, and stay there."""
        limits = {joint.name: joint.speed_rps for joint in rows()[0]}
        way = plan(self.goal, frames, limits, interpolation) if frames else None
        way_s = way.duration_s * until_share if way else 0.0
        for tick in range(1, round((way_s + hold_s) / TICK_S) + 1):
            if way:
                self.goal |= positions(way, min(way_s, tick * TICK_S))
            self.engine.step(drives(self.goal), TICK_S)
            self.seen.append(self.engine.pose())

    def lifted(self, foot):
        """How often a foot left the floor."""
        on = [foot in pose.on_floor for pose in self.seen]
        return sum(before and not after for before, after in pairwise(on))


def frames_of(motion, times=1):
    """The key frames of a motion with those of its lead-in and lead-out, which are played once."""
    lead_in, lead_out = (rows()[1][name].frames if name else () for name in (motion.lead_in, motion.lead_out))
    return (*lead_in, *motion.frames * times, *lead_out)
