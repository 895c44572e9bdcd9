"""The current motion: a way of all its joints, ways of single joints beside it, or one played by the controller."""

from collections.abc import Iterator, Mapping
from math import isnan, nan

from msgspec import Struct

from lbr.messages.joints import StoredMotion
from lbr.operations.joints import trajectory
from lbr.operations.joints.trajectory import Trajectory


class Way(Struct, frozen=True, kw_only=True):
    """The way of one joint with a start of its own; before 0 s it waits. `arrived` is the time at which its end was
    commanded (NaN: not yet)."""

    trajectory: Trajectory
    elapsed_s: float = 0.0
    arrived: float = nan


class Stored(Struct, frozen=True, kw_only=True):
    """A motion ordered from the servos' controller at `ordered_at`; `playing` since its report (NaN: not yet)."""

    motion: StoredMotion
    count: int
    ordered_at: float
    playing: float = nan


class ToFeet(Struct, frozen=True, kw_only=True):
    """The step of a stopped robot to a pose in which it stands, until `until` at the latest.

    It quotes the dead `lease`, so that a driver that ended this does not resume it. `pose` is the target of a straight
    way, from a position measured after `begun`. `stops` are the senders and ways of its stops, with the times they were
    sent. `lost`: then its mover is gone.
    """

    lease: str
    begun: float
    until: float
    names: tuple[str, ...] = ()
    trajectory: Trajectory | None = None
    elapsed_s: float = 0.0
    pose: Mapping[str, float] = {}
    followed: bool = False
    stops: Mapping[tuple[str, str], float] = {}
    lost: bool = False


class Move(Struct, frozen=True, kw_only=True):
    """A current motion, `elapsed_s` after the start of its trajectory; an offered one has no ways yet.

    `passed` is the number of key frames before the trajectory. `arrived` is the time at which its end was commanded
    (NaN: not yet). `beside` are the ways of joints that joined. `followed`: the driver reported that the servos follow;
    `ordered_at` is the time of the first setpoint under this lease. With `stay` it is not over when all have arrived.
    """

    goal: str
    begun: float
    ordered_at: float = nan
    trajectory: Trajectory | None = None
    elapsed_s: float = 0.0
    passed: int = 0
    arrived: float = nan
    beside: Mapping[str, Way] = {}
    stored: Stored | None = None
    followed: bool = False
    stay: bool = False

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that it moves."""
        return (*(() if self.trajectory is None else self.trajectory.knots), *self.beside)

    @property
    def targets(self) -> dict[str, float]:
        """Return the final positions of its joints."""
        return {name: way.targets[name] for name, way, _, _ in self.ways()}

    @property
    def offered(self) -> bool:
        """Return whether nothing of it has begun."""
        return self.trajectory is None and not self.beside and self.stored is None

    @property
    def over(self) -> bool:
        """Return whether the ends of all ways were commanded."""
        return not any(isnan(arrived) for _, _, _, arrived in self.ways())

    @property
    def over_since(self) -> float:
        """Return the time at which the last end was commanded, once all were."""
        return max((arrived for _, _, _, arrived in self.ways()), default=nan)

    def ways(self) -> Iterator[tuple[str, Trajectory, float, float]]:
        """Yield each joint, its way, its elapsed seconds, and the time at which its end was commanded."""
        if self.trajectory is not None:
            for name in self.trajectory.knots:
                yield name, self.trajectory, self.elapsed_s, self.arrived
        for name, way in self.beside.items():
            yield name, way.trajectory, way.elapsed_s, way.arrived

    def under_way(self) -> dict[str, float]:
        """Return the final positions of ways that are not over yet."""
        return {name: round(way.knots[name][-1], 5) for name, way, _, arrived in self.ways() if isnan(arrived)}

    def moved_since(self, when: float) -> set[str]:
        """Return the joints whose ways were not over by then."""
        return {name for name, _, _, arrived in self.ways() if not arrived <= when}

    def speeds(self) -> dict[str, float]:
        """Return the commanded speeds of its joints, in radians a second."""
        speeds_rps = {} if self.trajectory is None else trajectory.speeds(self.trajectory, self.elapsed_s)
        for way in self.beside.values():
            speeds_rps |= trajectory.speeds(way.trajectory, way.elapsed_s)
        return speeds_rps

    def positions(self) -> dict[str, float]:
        """Return the commanded positions of its joints."""
        positions_rad = {} if self.trajectory is None else trajectory.positions(self.trajectory, self.elapsed_s)
        for way in self.beside.values():
            positions_rad |= trajectory.positions(way.trajectory, way.elapsed_s)
        return positions_rad
