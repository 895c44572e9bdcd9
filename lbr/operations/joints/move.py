"""The motion under way: a way of all its joints, ways of single ones beside it, or what the controller plays by
itself."""

from collections.abc import Iterator, Mapping
from math import isnan, nan

from msgspec import Struct

from lbr.messages.joints import StoredMotion
from lbr.operations.joints import trajectory
from lbr.operations.joints.trajectory import Trajectory


class Way(Struct, frozen=True, kw_only=True):
    """The way of one joint that began for itself; before 0 s it waits. `arrived` is when its end was commanded (NaN:
    not yet)."""

    trajectory: Trajectory
    elapsed_s: float = 0.0
    arrived: float = nan


class Stored(Struct, frozen=True, kw_only=True):
    """A motion that the servos' controller is told to play; `playing` since it said so (NaN: not yet)."""

    motion: StoredMotion
    count: int
    told_at: float
    playing: float = nan


class ToFeet(Struct, frozen=True, kw_only=True):
    """The act of a robot that was stopped on its way: it goes on to where it stands, until `until` at the latest.

    It quotes the dead `lease`, so that a driver that ended this does not take it up again. `pose` is where it goes
    straight to, from where it is measured after `begun`. `stops` are who said so by which way, and when that was sent.
    `lost`: then its mover is gone.
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
    """A motion under way, `elapsed_s` after the start of its trajectory; what was only offered has none of its kinds
    yet.

    `passed` key frames lay behind when the trajectory began. `arrived` is when its end was commanded (NaN: not yet).
    `beside` are the ways of joints that joined. `followed`: the driver said that the servos follow; it has been told so
    since `told_at`, under this lease. With `stay` it is not over when all have arrived.
    """

    goal: str
    begun: float
    told_at: float = nan
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
        """Return where it leads its joints."""
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
        """Return when the last of these was; NaN while one was not."""
        return max((arrived for _, _, _, arrived in self.ways()), default=nan) if self.over else nan

    def ways(self) -> Iterator[tuple[str, Trajectory, float, float]]:
        """Yield each joint, its way, how far it has come on it in seconds, and when its end was commanded."""
        if self.trajectory is not None:
            for name in self.trajectory.knots:
                yield name, self.trajectory, self.elapsed_s, self.arrived
        for name, way in self.beside.items():
            yield name, way.trajectory, way.elapsed_s, way.arrived

    def under_way(self) -> dict[str, float]:
        """Return where ways lead that are not over yet."""
        return {name: round(way.knots[name][-1], 5) for name, way, _, arrived in self.ways() if isnan(arrived)}

    def moved_since(self, when: float) -> set[str]:
        """Return the joints whose ways were not over by then."""
        return {name for name, _, _, arrived in self.ways() if not arrived <= when}

    def speeds(self) -> dict[str, float]:
        """Return how fast its joints are to go now, in radians a second."""
        found = {} if self.trajectory is None else trajectory.speeds(self.trajectory, self.elapsed_s)
        for way in self.beside.values():
            found |= trajectory.speeds(way.trajectory, way.elapsed_s)
        return found

    def positions(self) -> dict[str, float]:
        """Return where its joints are to be now."""
        found = {} if self.trajectory is None else trajectory.positions(self.trajectory, self.elapsed_s)
        for way in self.beside.values():
            found |= trajectory.positions(way.trajectory, way.elapsed_s)
        return found
