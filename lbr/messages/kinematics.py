"""The wheels of a base as rows, and its kinematics: from a twist to the speed of each motor, and back.

    twist (vx, vy, wz) ── Base.speeds ──► speed of each motor at its wheels' rims        inverse kinematics
    way or speed of each motor ── Base.twist ──► twist                                   forward kinematics

x is ahead, y left, wz anticlockwise (REP 103). A wheel at (x, y) rolls along `yaw_rad`; its rollers, if it has some,
let it slide along their own direction. Everything here is pure.
"""

from collections.abc import Iterable, Iterator, Sequence
from math import copysign, cos, isfinite, sin
from typing import Annotated, Literal

from msgspec import Meta, Struct
from msgspec.structs import replace

from lbr.messages.rows import Fault, Others, Row
from lbr.messages.units import Name, Vector

BaseKind = Literal["differential", "skid", "mecanum", "omni"]
HOLONOMIC = frozenset({"mecanum", "omni"})
"""Kinds of bases that can move sideways."""
TWO = ("left", "right")
"""The motors of a base without rows: their powers have fields of their own in messages."""
ALIKE = 1e-6
"""The tolerance between the speeds of wheels on one motor, for numbers that people have rounded."""
SINGULAR = 1e-9
Place = Annotated[float, Meta(ge=-5.0, le=5.0)]


class Twist(Struct, frozen=True, kw_only=True):
    """The motion of a base: metres a second ahead and to the left, radians a second anticlockwise."""

    vx_mps: float = 0.0
    vy_mps: float = 0.0
    wz_rps: float = 0.0

    def times(self, factor: float) -> "Twist":
        """Return the same motion, faster or slower."""
        return Twist(vx_mps=self.vx_mps * factor, vy_mps=self.vy_mps * factor, wz_rps=self.wz_rps * factor)


class Base(Struct, frozen=True, kw_only=True):
    """The motion of a base by its wheels. The orders of `per_twist`, `per_speed` and `diameters_m` are that of
    `motors`.

    A motor's speed is its `per_twist` times vx, vy and wz; its share in the twist is its `per_speed` times its speed.
    `track_m` is twice the speed of the fastest wheel in a spin of 1 rad/s.
    """

    kind: BaseKind
    motors: tuple[str, ...]
    per_twist: tuple[Vector, ...]
    per_speed: tuple[Vector, ...]
    diameters_m: tuple[float | None, ...]
    track_m: float

    @property
    def holonomic(self) -> bool:
        """Return whether it can move sideways."""
        return self.kind in HOLONOMIC

    @property
    def two(self) -> bool:
        """Return whether its motors are `left` and `right`, and nothing else."""
        return self.motors == TWO

    def speeds(self, twist: Twist) -> tuple[float, ...]:
        """Return the speed of each motor at its wheels' rims; NaN in, NaN out."""
        return tuple(x * twist.vx_mps + y * twist.vy_mps + w * twist.wz_rps for x, y, w in self.per_twist)

    def twist(self, speeds: Sequence[float]) -> Twist:
        """Return the twist that best fits the motors' speeds; for distances instead of speeds, distance and turn."""
        shares = list(zip(self.per_speed, speeds, strict=True))
        vx, vy, wz = (sum(share[axis] * speed for share, speed in shares) for axis in range(3))
        return Twist(vx_mps=vx, vy_mps=vy, wz_rps=wz)

    def powers(self, left: float, right: float, aside: float) -> tuple[float, ...]:
        """Return each motor's power from those of the two sides and sideways, all as fractions of the same speed."""
        if self.two:
            return left, right
        return self.speeds(Twist(vx_mps=(left + right) / 2, vy_mps=aside, wz_rps=(right - left) / self.track_m))

    def sides(self, speeds: Sequence[float]) -> tuple[float, float, float]:
        """Return the speeds or powers of the two sides and sideways from those of the motors."""
        twist = self.twist(speeds)
        turn = twist.wz_rps * self.track_m / 2
        return twist.vx_mps - turn, twist.vx_mps + turn, twist.vy_mps

    def fitting(self, left: float, right: float, aside: float, most: float) -> float:
        """Return the factor by which all must be slowed down so that no motor exceeds `most`; NaN and infinity: 0."""
        powers = (left, right, aside, *self.powers(left, right, aside))
        if not all(map(isfinite, powers)):
            return 0.0
        fastest = max(map(abs, self.powers(left, right, aside)))
        return most / fastest if fastest > most else 1.0


class Wheel(Row, frozen=True, kw_only=True):
    """The driven wheels. Axes are REP 103's: x ahead, y left, from the middle of the base; angles are anticlockwise."""

    TABLE = "wheel"
    KEY = ("name",)

    name: Annotated[Name, "its name for people"]
    motor: Annotated[Name, "its motor, which may drive several"]
    x_m: Annotated[Place, "ahead of the middle of the base"] = 0.0
    y_m: Annotated[Place, "to the left of it"] = 0.0
    yaw_rad: Annotated[float, Meta(ge=-7.0, le=7.0), "its direction, motor forward: 0 ahead, 1.5708 left"] = 0.0
    roller_rad: Annotated[
        float,
        Meta(ge=-1.4, le=1.4),
        "from its axle to its rollers', anticlockwise; mecanum: ±0.7854",
    ] = 0.0
    diameter_m: Annotated[float, Meta(gt=0.0, le=2.0), "of the wheel, rollers included"]


def _key(row: Wheel) -> str:
    return row.name


def _name(row: "Kinematics") -> str:
    return row.name


def _one_base(row: "Kinematics", others: Others) -> Iterator[Fault]:
    if next(iter(others.index(Kinematics, _name)), row.name) != row.name:
        yield "name", "a robot has one base: drop this row, or the other"


def _wheels_fit(row: "Kinematics", others: Others) -> Iterator[Fault]:
    wheels = tuple(others.index(Wheel, _key).values())
    if trouble := trouble_of(row.kind, wheels, row.track_factor):
        yield "kind", trouble


class Kinematics(Row, frozen=True, kw_only=True):
    """The arrangement of the base's wheels: one row. A robot without it has two driven wheels, on the motors `left` and
    `right`."""

    TABLE = "kinematics"
    KEY = ("name",)
    CHECKS = (_one_base, _wheels_fit)

    name: Annotated[Name, "a name for the base"]
    kind: Annotated[BaseKind, "mecanum and omni move sideways"]
    track_factor: Annotated[
        float,
        Meta(ge=0.5, le=5.0),
        "factor on the wheels' way in a turn; above 1 where they slip",
    ] = 1.0


def differential(track_m: float) -> Base:
    """Return a base with two driven wheels, `track_m` apart."""
    half = track_m / 2
    wheels = (
        Wheel(name="left", motor="left", y_m=half, diameter_m=1.0),
        Wheel(name="right", motor="right", y_m=-half, diameter_m=1.0),
    )
    return replace(_base("differential", wheels, 1.0), diameters_m=(None, None), track_m=track_m)


def base_of(rows: Iterable[Kinematics], wheels: Iterable[Wheel], track_m: float) -> Base:
    """Return the base of these rows; without rows, one with two driven wheels, `track_m` apart."""
    row = next(iter(rows), None)
    if row is None:
        return differential(track_m)
    wheels = tuple(wheels)
    if trouble := trouble_of(row.kind, wheels, row.track_factor):
        raise ValueError(f"kinematics '{row.name}': {trouble}")
    return _base(row.kind, wheels, row.track_factor)


def trouble_of(kind: BaseKind, wheels: Sequence[Wheel], track_factor: float) -> str:
    """Return why these wheels are not a base of this kind, with the cure; empty if they are."""
    if not wheels:
        return "there is no row of wheel: add one for each driven wheel, or drop this row"
    for wheel in wheels:
        if kind not in HOLONOMIC and (wheel.yaw_rad != 0.0 or wheel.roller_rad != 0.0 or wheel.y_m == 0.0):
            return f"wheel '{wheel.name}' must stand beside the middle (y_m), and roll ahead (yaw_rad and roller_rad 0)"
        if kind == "mecanum" and wheel.roller_rad == 0.0:
            return f"wheel '{wheel.name}' needs roller_rad, 0.7854 or -0.7854: the rollers of mecanum wheels lie askew"
        if kind == "omni" and wheel.roller_rad != 0.0:
            return f"wheel '{wheel.name}' has roller_rad: the rollers of omni wheels are at right angles, so it is 0"
    return _uneven(wheels, track_factor) or _too_few(kind, wheels, track_factor)


def _uneven(wheels: Sequence[Wheel], track_factor: float) -> str:
    """Return the wheels on one motor that would have to turn at different speeds, or an empty text."""
    first: dict[str, Wheel] = {}
    for wheel in wheels:
        other = first.setdefault(wheel.motor, wheel)
        here, there = _rolls(wheel, track_factor), _rolls(other, track_factor)
        if max(abs(a - b) for a, b in zip(here, there, strict=True)) > ALIKE:
            both = f"wheels '{other.name}' and '{wheel.name}'"
            return (
                f"{both} are on motor '{wheel.motor}' and would have to turn at different speeds: correct their places"
            )
    return ""


def _too_few(kind: BaseKind, wheels: Sequence[Wheel], track_factor: float) -> str:
    """Return why the motors cannot make all motions of such a base, or an empty text."""
    motors = {wheel.motor: copysign(1.0, wheel.y_m) for wheel in wheels}
    if kind in HOLONOMIC:
        if _solved(kind, [_rolls(wheel, track_factor) for wheel in wheels]) is None:
            return "these wheels do not move ahead, sideways and round: look at their places, yaw_rad and roller_rad"
        return ""
    if set(motors.values()) != {1.0, -1.0}:
        return "there must be a motor on each side (y_m positive and negative)"
    if kind == "differential" and len(motors) != 2:
        return f"a differential base has two motors, one on each side, not {len(motors)}: more are kind 'skid'"
    return ""


def _base(kind: BaseKind, wheels: Iterable[Wheel], track_factor: float) -> Base:
    by_motor = {wheel.motor: wheel for wheel in reversed(tuple(wheels))}
    motors = TWO if set(by_motor) == set(TWO) else tuple(sorted(by_motor))
    per_twist = tuple(_rolls(by_motor[motor], track_factor) for motor in motors)
    per_speed = _solved(kind, per_twist)
    assert per_speed is not None, "trouble_of comes before"
    return Base(
        kind=kind,
        motors=motors,
        per_twist=per_twist,
        per_speed=per_speed,
        diameters_m=tuple(by_motor[motor].diameter_m for motor in motors),
        track_m=2 * max(abs(turning) for _, _, turning in per_twist),
    )


def _rolls(wheel: Wheel, track_factor: float) -> Vector:
    """Return how fast a wheel rolls for each of vx, vy and wz.

    The floor moves under the wheel by (vx - wz y, vy + wz x). Rollers let it slide along their own direction, so only
    the component across it counts (Lynch and Park, Modern Robotics, 13.2).
    """
    along = wheel.yaw_rad + wheel.roller_rad
    ahead, aside = cos(along) / cos(wheel.roller_rad), sin(along) / cos(wheel.roller_rad)
    return ahead, aside, (aside * wheel.x_m - ahead * wheel.y_m) * track_factor


def _solved(kind: BaseKind, per_twist: Sequence[Vector]) -> tuple[Vector, ...] | None:
    """Return each motor's share in the twist that fits all speeds best; None if they do not determine it."""
    axes = (0, 1, 2) if kind in HOLONOMIC else (0, 2)
    normal = [[sum(row[a] * row[b] for row in per_twist) for b in axes] for a in axes]
    inverse = _inverted(normal)
    if inverse is None:
        return None
    shares_of_motors: list[Vector] = []
    for row in per_twist:
        shares = dict(
            zip(axes, (sum(w * row[b] for w, b in zip(line, axes, strict=True)) for line in inverse), strict=True)
        )
        shares_of_motors.append((shares[0], shares.get(1, 0.0), shares[2]))
    return tuple(shares_of_motors)


def _inverted(matrix: list[list[float]]) -> list[list[float]] | None:
    """Return the inverse of a small matrix by elimination; None if it has none."""
    size = len(matrix)
    rows = [[*line, *(float(at == column) for column in range(size))] for at, line in enumerate(matrix)]
    for column in range(size):
        pivot = max(range(column, size), key=lambda at: abs(rows[at][column]))
        if not abs(rows[pivot][column]) > SINGULAR:
            return None
        rows[column], rows[pivot] = rows[pivot], rows[column]
        scale = rows[column][column]
        rows[column] = [value / scale for value in rows[column]]
        for at in range(size):
            if at != column:
                factor = rows[at][column]
                rows[at] = [value - factor * top for value, top in zip(rows[at], rows[column], strict=True)]
    return [line[size:] for line in rows]
