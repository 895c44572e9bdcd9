"""The key frames of a motion in which the simulated body stands: it plays up to each of them, stops, and is watched."""

import random
from collections.abc import Iterator, Mapping, Sequence

import msgspec

from lbr.database.rows import RobotRows
from lbr.messages.joints import Joint, KeyFrame
from lbr.operations.joints import trajectory
from lbr.simulation.humanoid.balance import Balance
from lbr.simulation.humanoid.settings import HumanoidWorldSettings

WORLD = "humanoid_world"
ROUNDS = (1, 2)
"""The rounds in which a walk is stopped: its first, from rest, and its second, under way."""
ASKEW_RAD = 0.006
"""The standard deviation of a joint's zero: a third of a degree, as after a calibration by hand."""
SEEDS = (1, 2, 3)


def world(rows: RobotRows, robot: str) -> HumanoidWorldSettings:
    """Return the simulation of a robot: of its rows, or with the body of its name."""
    found = (row.settings for row in rows.capabilities if row.kind == WORLD)
    return msgspec.json.decode(next(found, f'{{"model": "{robot}"}}'), type=HumanoidWorldSettings)


def stable_frames(
    settings: HumanoidWorldSettings,
    joints: Sequence[Joint],
    home: str,
    lead_in: Sequence[KeyFrame],
    frames: Sequence[KeyFrame],
) -> Iterator[bool]:
    """Yield for each key frame whether the body stays on its feet there, with each of several errors of its joints."""
    rounds = ROUNDS if lead_in else ROUNDS[:1]
    for at in range(len(frames)):
        ways = [(*lead_in, *tuple(frames) * (count - 1), *frames[: at + 1]) for count in rounds]
        yield all(_stands(settings, joints, home, way, seed) for way in ways for seed in SEEDS)


def _stands(
    settings: HumanoidWorldSettings, joints: Sequence[Joint], home: str, frames: Sequence[KeyFrame], seed: int
) -> bool:
    chance = random.Random(seed)
    askew = {joint.name: chance.gauss(0.0, ASKEW_RAD) for joint in joints}
    start = {joint.name: min(max(0.0, joint.lower_rad), joint.upper_rad) for joint in joints} | frames[0].positions
    way = trajectory.plan(start, frames, {joint.name: joint.speed_rps for joint in joints})

    def goals(t: float) -> Mapping[str, float]:
        return {name: at + askew[name] for name, at in {**start, **trajectory.positions(way, t)}.items()}

    balance = Balance(settings, joints, home, goals=goals, duration_s=way.duration_s, frame=lambda _t: 1)
    for _ in balance.play():
        pass
    return balance.report.stands
