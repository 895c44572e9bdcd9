"""How near to the range that was asked for a base rests: board, parser, drive kernel and odometry in lockstep with the world.

Nothing sleeps; the same seed gives the same figures. The sonars' noise is the world's own, 8 mm.
"""

from collections.abc import Iterator
from random import Random
from typing import NamedTuple

from msgspec.structs import replace

from lbr.messages.drive import DriveCommand, GoalResult
from lbr.messages.motors import MotorsState
from lbr.operations.drive.settings import DriveSettings
from lbr.operations.drive.state import OdometrySeen
from lbr.operations.odometry import OdometrySettings
from lbr.operations.odometry.reckoning import Reckoning
from lbr.simulation.settings import Body, BoxSettings, WorldSettings
from tests.models.lockstep import ARMED, HOP_S, Lockstep
from tests.support.figures import Promise, Results

WALL_M, THICK_M, HALF_M = 1.5, 0.1, Body().length_m / 2
WALLS = tuple(
    BoxSettings(name=name, x_m=x_m, y_m=0.0, length_m=THICK_M, width_m=4.0, height_m=1.5)
    for name, x_m in (("ahead", WALL_M), ("behind", -WALL_M))
)
COUNT_S, RECKON_S = 0.06, 0.04
"""How often the motors tell their counts, as measured of the running robot, and how often the odometry works."""
REST_S, MOST_S = 0.6, 40.0
NEAR_CM = 1.0
POWERS = (0.1, 0.2, 0.25, 0.4, 0.8)

PROMISES: dict[str, Promise] = {
    "R1": Promise(what="from the range that was asked for, the base rests", unit="cm", target=0.5, statistic="p50"),
    "R1 p95": Promise(what="the same", unit="cm", target=NEAR_CM, statistic="p95"),
    "R2": Promise(what="every move to a range ends reached"),
    "R3": Promise(what="time of a move to a range", unit="s", statistic="p50"),
}


class Stop(NamedTuple):
    """A range, the sensor that is to read it, and which way to drive."""

    angle_deg: float
    sensor: str
    range_cm: float

    def __str__(self) -> str:
        return f"{'ahead' if self.angle_deg == 0.0 else 'back'} until {self.sensor} is at {self.range_cm:g} cm"


STOPS = (
    Stop(0.0, "forward", 57.0), Stop(180.0, "forward", 90.0), Stop(0.0, "forward", 40.0), Stop(180.0, "back", 57.0),
    Stop(0.0, "back", 90.0), Stop(180.0, "back", 30.0), Stop(0.0, "forward", 30.0), Stop(180.0, "back", 40.0),
    Stop(0.0, "forward", 90.0),
)  # fmt: skip
"""One after the other, between the walls."""


class Ranging(Lockstep):
    """A robot between two walls that counts its wheels and is asked for ranges."""

    def __init__(self, random: Random, drive: DriveSettings) -> None:
        super().__init__(WorldSettings(seed=random.randrange(1 << 30), walls=WALLS, dock=None), drive, random)
        self._reckoning = Reckoning(OdometrySettings(), "o")
        self._counted: list[tuple[float, MotorsState]] = []
        self._loops = (*self._loops, (COUNT_S, self._count), (RECKON_S, self._reckon))
        self._next += [random.uniform(0.0, COUNT_S), random.uniform(0.0, RECKON_S)]

    def stop(self, stop: Stop, power: float) -> tuple[GoalResult | None, float]:
        """Drive to a range; return the result and how long it took, once the base is at rest."""
        before, since = len(self.results), self.now
        self.ask(DriveCommand(power=power, angle_deg=stop.angle_deg, range_cm=stop.range_cm, sensor=stop.sensor))
        while self.now - since < MOST_S and not self.refusal and len(self.results) == before:
            self.step()
        took_s = self.now - since
        self.ask(None)
        self.run(REST_S)
        return (self.results[-1] if len(self.results) > before else None), took_s

    def _count(self) -> None:
        left, right = self.engine.sensed().counts
        self._counted.append((self.now + HOP_S, replace(ARMED, counts_left=left, counts_right=right)))

    def _reckon(self) -> None:
        while self._counted and self._counted[0][0] <= self.now:
            arrived, motors = self._counted.pop(0)
            self._reckoning.count(motors, arrived)
            self._send(OdometrySeen(odometry=self._reckoning.state(), arrived=self.now + HOP_S), HOP_S)


def true_cm(sensor: str, x_m: float) -> float:
    """Return how far its wall is from a sensor."""
    return (WALL_M - THICK_M / 2 - HALF_M - (x_m if sensor == "forward" else -x_m)) * 100


def measure(
    results: Results, rounds: int, seed: int, powers: tuple[float, ...] = POWERS
) -> Iterator[tuple[Stop, float, float]]:
    """Ask for each of the stops with each power so often; yield each with what it was off by."""
    for number in range(rounds):
        for power in powers:
            robot = Ranging(Random(f"{seed} {number} {power}"), DriveSettings(max_run_s=60.0))
            robot.run(1.0)
            for stop in STOPS:
                result, took_s = robot.stop(stop, power)
                off_cm = true_cm(stop.sensor, robot.engine.pose().x_m) - stop.range_cm
                ended = result is not None and result.result == "reached"
                results.check("R2", [] if ended else [f"{stop}: {result.reason if result else robot.refusal}"])
                results.sample("R1", abs(off_cm))
                results.sample("R1 p95", abs(off_cm))
                results.sample("R3", took_s)
                yield stop, power, off_cm
