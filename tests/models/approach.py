"""Somebody steps in the robot's way: S20, and S15 for each sensor. Faster than real time, and the same at each run.

S20: the base moves at 0.5 m/s when somebody (a box 0.3 to 0.5 m wide) appears 0.5 m from its outline: ahead or behind
while it drives straight, to its left or right while it drives an arc to that side, forwards or backwards. Each trial
is one that ends in a collision if nobody brakes: what would have passed by itself does not count. The sensors' noise
grows with the distance, and one reading in a hundred is missing.

Spinning on the spot, a base of this shape sweeps 11 cm beyond its sides: nothing 0.5 m away is in its way.
"""

from collections.abc import Iterator
from math import cos, pi, radians, sin
from random import Random
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from lbr.operations.drive.mixing import mix
from lbr.operations.drive.settings import DriveSettings
from lbr.simulation.devices.ultrasonic_ring import UltrasonicFaults
from lbr.simulation.engine import Engine
from lbr.simulation.messages import WorldBox
from lbr.simulation.model import TIMESTEP_S
from lbr.simulation.settings import BoxSettings, Ultrasonic, WorldSettings
from tests.models.lockstep import Lockstep, box_corners, corners, gap_m
from tests.support.figures import Promise, Results

Side = Literal["forward", "back", "left", "right"]
SIDES: tuple[Side, ...] = ("forward", "back", "left", "right")
LOOKS: dict[Side, float] = {"forward": 0.0, "back": pi, "left": pi / 2, "right": -pi / 2}
SPEED_MPS = 0.5
AWAY_M = 0.5
LONGEST_S = 8.0
ARCS_DEG = (4.0, 30.0)
NOISY = Ultrasonic(noise_m=0.01, noise_per_m=0.01, dropout=0.01)
EMPTY = WorldSettings(walls=(), dock=None, ultrasonic=NOISY)

HALL = tuple(
    BoxSettings(name=name, x_m=x, y_m=y, length_m=length, width_m=width)
    for name, x, y, length, width in (
        ("ahead", 4.0, 0.0, 0.1, 8.0),
        ("behind", -4.0, 0.0, 0.1, 8.0),
        ("left", 0.0, 4.0, 8.0, 0.1),
        ("right", 0.0, -4.0, 8.0, 0.1),
    )
)
IN_A_HALL = WorldSettings(walls=HALL, dock=None, ultrasonic=Ultrasonic(noise_m=0.01, noise_per_m=0.01))
"""Walls to measure, and no reading missing: one that is frozen on "nothing within reach" cannot be told from the truth."""

PROMISES = {
    **{
        f"S20 {side}": Promise(
            what=f"somebody appears 50 cm {side} at 0.5 m/s: how much of that is used up", unit="cm", target=45, hard=50
        )
        for side in SIDES
    },
    **{f"S15 {side}": Promise(what=f"{side} sensor silent, garbled or blind, to motor zero", target=400, hard=600) for side in SIDES},
    **{f"S15 {side} frozen": Promise(what=f"{side} sensor repeats itself, to motor zero", target=400, hard=1000) for side in SIDES},
}  # fmt: skip


class Trial(Struct, frozen=True, kw_only=True):
    """How the base moves, and who appears: `thing` is given from the robot (x ahead, y left)."""

    seed: int
    side: Side
    power: float
    angle_deg: float
    thing: WorldBox


class Outcome(Struct, frozen=True, kw_only=True):
    """What became of a trial: `way_m` from the appearance to standing still, `closest_m` what was left between."""

    contact: bool
    way_m: float
    closest_m: float
    stopped: bool


def trials(side: Side, count: int, seed: int, *, wide_m: tuple[float, float] = (0.3, 0.5)) -> Iterator[Trial]:
    """Yield trials that would each end in a collision."""
    random, found = Random(f"{seed} {side}"), 0
    while found < count:
        trial = _drawn(side, random, wide_m)
        if _collides(trial):
            found += 1
            yield trial


def run(trial: Trial, drive: DriveSettings) -> Outcome:
    """Drive, let somebody appear, and see."""
    random = Random(trial.seed)
    rig = Lockstep(replace(EMPTY, seed=trial.seed), drive, random)
    rig.run(0.8)
    rig.drive(trial.power, trial.angle_deg)
    rig.run(1.2 + random.uniform(0.0, 0.15))
    thing = _placed(trial.thing, rig.engine)
    rig.engine.place(thing)
    outline, contact, closest_m, way_m, still_s = box_corners(thing), False, AWAY_M, 0.0, 0.0
    began = rig.now
    while rig.now - began < LONGEST_S and still_s < 0.5 and not contact:
        rig.step()
        pose = rig.engine.pose()
        body = rig.engine.settings.body
        closest_m = min(
            closest_m, gap_m(corners(pose.x_m, pose.y_m, pose.yaw_rad, body.length_m, body.width_m), outline)
        )
        contact = pose.touching
        way_m += abs(pose.speed_mps) * TIMESTEP_S
        still = abs(pose.speed_mps) < 0.005 and abs(pose.turn_rps) < 0.02
        still_s = still_s + TIMESTEP_S if still else 0.0
    return Outcome(contact=contact, way_m=way_m, closest_m=closest_m, stopped=still_s >= 0.5)


def approach(results: Results, count: int, seed: int, drive: DriveSettings) -> dict[Side, list[Outcome]]:
    """S20, from each side."""
    found: dict[Side, list[Outcome]] = {}
    for side in SIDES:
        found[side] = []
        for trial in trials(side, count, seed):
            outcome = run(trial, drive)
            found[side].append(outcome)
            results.sample(f"S20 {side}", (AWAY_M - outcome.closest_m) * 100)
            results.check(f"S20 {side}", [f"contact in {trial}"] if outcome.contact else [])
    return found


def failing(results: Results, count: int, seed: int, drive: DriveSettings) -> None:
    """S15, for each sensor that the motion is towards."""
    random = Random(f"{seed} failing")
    for side in SIDES:
        broken: dict[str, UltrasonicFaults] = {
            "silent": UltrasonicFaults(silent=True),
            "garbled": UltrasonicFaults(garbage=1.0),
            "cut short": UltrasonicFaults(half_lines=1.0),
            "in error": UltrasonicFaults(error=(side,)),
            "gone": UltrasonicFaults(missing=(side,)),
            "frozen": UltrasonicFaults(frozen=True),
        }
        for name, faults in broken.items():
            figure = f"S15 {side} frozen" if name == "frozen" else f"S15 {side}"
            for _ in range(count):
                took_s = _stopped_after(side, faults, random, drive)
                if took_s is None:
                    results.check(figure, [f"{name}: still driving after {LONGEST_S:g} s"])
                else:
                    results.sample(figure, took_s * 1000)


def _stopped_after(side: Side, faults: UltrasonicFaults, random: Random, drive: DriveSettings) -> float | None:
    rig = Lockstep(replace(IN_A_HALL, seed=random.randrange(1 << 30)), drive, random)
    rig.run(0.8)
    rig.drive(
        *(_arc(side, random, 10.0) if side in {"left", "right"} else (SPEED_MPS, 0.0 if side == "forward" else 180.0))
    )
    rig.run(1.2 + random.uniform(0.0, 0.15))
    if rig.power == (0.0, 0.0):
        raise RuntimeError(f"nothing moved before the fault: {rig.refusal}")
    rig.fault(faults)
    began = rig.now
    while rig.now - began < LONGEST_S:
        rig.step()
        if rig.halted:
            return rig.now - began
    return None


def thin(count: int, seed: int, drive: DriveSettings) -> dict[Side, int]:
    """Return how many of as many posts, 5 cm thick, are touched: what is beside the sensor's cone is not seen."""
    ahead: tuple[Side, ...] = ("forward", "back")
    return {
        side: sum(run(trial, drive).contact for trial in trials(side, count, seed, wide_m=(0.05, 0.05)))
        for side in ahead
    }


def _drawn(side: Side, random: Random, wide_m: tuple[float, float]) -> Trial:
    length, width = random.uniform(0.2, 0.4) * wide_m[0] / 0.3, random.uniform(*wide_m)
    straight = side in {"forward", "back"}
    turned = LOOKS[side] + random.uniform(-0.3, 0.3)
    body = EMPTY.body
    face_m = (body.length_m if straight else body.width_m) / 2
    aside_m = random.uniform(-0.15, 0.15)
    own = corners(0.0, 0.0, 0.0, body.length_m, body.width_m)
    look, near, far = LOOKS[side], face_m + AWAY_M, face_m + AWAY_M + 1.0
    for _ in range(30):
        middle = (near + far) / 2
        x, y = middle * cos(look) - aside_m * sin(look), middle * sin(look) + aside_m * cos(look)
        near, far = (middle, far) if gap_m(own, corners(x, y, turned, length, width)) < AWAY_M else (near, middle)
    power, angle_deg = (SPEED_MPS, 0.0 if side == "forward" else 180.0) if straight else _arc(side, random)
    thing = WorldBox(name="somebody", x_m=x, y_m=y, length_m=length, width_m=width, yaw_rad=turned)
    return Trial(seed=random.randrange(1 << 30), side=side, power=power, angle_deg=angle_deg, thing=thing)


def _arc(side: Side, random: Random, least_deg: float = ARCS_DEG[0]) -> tuple[float, float]:
    """Return an arc to that side, forwards or backwards, on which the base's middle moves at `SPEED_MPS`."""
    steep = random.uniform(least_deg, ARCS_DEG[1])
    power = SPEED_MPS * (cos(radians(steep)) + sin(radians(steep))) / cos(radians(steep))
    to_left = -steep if random.random() < 0.5 else 180.0 - steep
    return power, (to_left if side == "left" else -to_left) % 360.0


def _collides(trial: Trial) -> bool:
    """Say whether the trial ends in a collision if nobody brakes."""
    engine = Engine(EMPTY)
    wheels = mix(trial.power, trial.angle_deg, DriveSettings())
    engine.step(*wheels, 1.2)
    engine.place(_placed(trial.thing, engine))
    for _ in range(round(LONGEST_S / 2 / 0.02)):
        engine.step(*wheels, 0.02)
        if engine.touching():
            return True
    return False


def _placed(thing: WorldBox, engine: Engine) -> WorldBox:
    pose = engine.pose()
    c, s = cos(pose.yaw_rad), sin(pose.yaw_rad)
    x, y = pose.x_m + c * thing.x_m - s * thing.y_m, pose.y_m + s * thing.x_m + c * thing.y_m
    return replace(thing, x_m=x, y_m=y, yaw_rad=thing.yaw_rad + pose.yaw_rad)
