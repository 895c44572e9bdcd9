"""The start places of trials: anywhere in the room where the robot can stand and turn."""

from math import pi
from random import Random

from msgspec.structs import replace

from lbr.simulation.engine import Engine
from lbr.simulation.room import ROOM
from lbr.simulation.settings import StartPose, WorldSettings

FURNISHED_X_M, FURNISHED_Y_M = (-1.5, 4.5), (-2.5, 2.5)
"""Of the furnished room, without the hall behind its door."""
TURN_POWER, STEP_S, TURN_STEPS = 0.15, 0.02, 450
"""More than a whole turn."""
MOST_TRIES = 200


def starts(world: WorldSettings, count: int, seed: int) -> list[StartPose]:
    """Return start places: that of the world, then random ones."""
    random, poses = Random(seed), [world.start]
    across, along = _extent(world)
    for _ in range(MOST_TRIES * count):
        if len(poses) >= count:
            break
        pose = StartPose(x_m=random.uniform(*across), y_m=random.uniform(*along), yaw_rad=random.uniform(-pi, pi))
        if free(world, pose):
            poses.append(pose)
    return poses[:count]


def free(world: WorldSettings, start: StartPose) -> bool:
    """Return whether the robot can stand and turn there without touching anything, including its dock."""
    engine = Engine(replace(world, start=start))
    for _ in range(TURN_STEPS):
        engine.step(-TURN_POWER, TURN_POWER, STEP_S)
        if engine.touching(dock=True):
            return False
    return True


def _extent(world: WorldSettings) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the extent of the walls."""
    if world.walls == ROOM:
        return FURNISHED_X_M, FURNISHED_Y_M
    solid = [wall for wall in world.walls if wall.solid]
    across = [wall.x_m for wall in solid] or [-2.0, 2.0]
    along = [wall.y_m for wall in solid] or [-2.0, 2.0]
    return (min(across), max(across)), (min(along), max(along))
