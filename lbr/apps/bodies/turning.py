"""Rotations as unit quaternions (w, x, y, z), and places relative to one another, as body descriptions need them."""

from collections.abc import Sequence
from math import asin, atan2, cos, hypot, pi, sin, sqrt
from typing import NamedTuple

from lbr.apps.bodies.parts import Xyz

Turn = tuple[float, float, float, float]
NO_TURN: Turn = (1.0, 0.0, 0.0, 0.0)
_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_UPRIGHT = 1.0 - 1e-9
"""The sine from which pitch counts as vertical: roll and yaw are then about one axis, and all of it is yaw."""


class Place(NamedTuple):
    """The place of axes relative to others."""

    xyz: Xyz = (0.0, 0.0, 0.0)
    turn: Turn = NO_TURN

    def then(self, inner: "Place") -> "Place":
        """Convert a place in these axes to one in the outer axes."""
        return Place(added(self.xyz, rotated(self.turn, inner.xyz)), product(self.turn, inner.turn))


def added(a: Xyz, b: Xyz) -> Xyz:
    """Return the sum."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def product(a: Turn, b: Turn) -> Turn:
    """Return the rotation `b`, then `a`, both about the outer axes."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def rotated(turn: Turn, vector: Xyz) -> Xyz:
    """Return a rotated vector."""
    w, x, y, z = turn
    _, rx, ry, rz = product(product(turn, (0.0, *vector)), (w, -x, -y, -z))
    return rx, ry, rz


def unit(values: Sequence[float]) -> tuple[float, ...]:
    """Return a vector scaled to length 1; raise ValueError if its length is 0."""
    length = sqrt(sum(value * value for value in values))
    if not length > 1e-12:
        raise ValueError(f"{' '.join(map(str, values))} has no length")
    return tuple(value / length for value in values)


def about(axis: Sequence[float], angle_rad: float) -> Turn:
    """Return a rotation about an axis."""
    x, y, z = unit(axis)
    s = sin(angle_rad / 2)
    return cos(angle_rad / 2), x * s, y * s, z * s


def by_euler(angles_rad: Sequence[float], order: str) -> Turn:
    """Return three rotations in sequence, about axes that turn along (small letters) or stay (capitals)."""
    turn = NO_TURN
    for letter, angle in zip(order, angles_rad, strict=True):
        one = about(_AXES[letter.lower()], angle)
        turn = product(turn, one) if letter.islower() else product(one, turn)
    return turn


def by_axes(x: Sequence[float], y: Sequence[float]) -> Turn:
    """Return the rotation of the x axis to `x`, and of the y axis into the plane of `x` and `y`."""
    ex = unit(x)
    along = sum(a * b for a, b in zip(ex, y, strict=True))
    ey = unit([b - along * a for a, b in zip(ex, y, strict=True)])
    ez = (ex[1] * ey[2] - ex[2] * ey[1], ex[2] * ey[0] - ex[0] * ey[2], ex[0] * ey[1] - ex[1] * ey[0])
    return _of_columns(ex, ey, ez)


def by_z(z: Sequence[float]) -> Turn:
    """Return the shortest rotation of the z axis to `z`."""
    x, y, up = unit(z)
    aside = hypot(x, y)
    if aside < 1e-10:
        return NO_TURN if up > 0 else (0.0, 1.0, 0.0, 0.0)
    return about((-y, x, 0.0), atan2(aside, up))


def rpy(turn: Turn) -> Xyz:
    """Return roll, pitch and yaw about fixed axes."""
    w, x, y, z = unit(turn)
    up = max(-1.0, min(1.0, 2 * (w * y - z * x)))
    if abs(up) > _UPRIGHT:
        return 0.0, pi / 2 if up > 0 else -pi / 2, 2 * (-1.0 if up > 0 else 1.0) * atan2(x, w)
    return (
        atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
        asin(up),
        atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
    )


def _of_columns(ex: Sequence[float], ey: Sequence[float], ez: Sequence[float]) -> Turn:
    """Convert a matrix to a quaternion, by its largest component (Shepperd)."""
    trace = ex[0] + ey[1] + ez[2]
    parts = (trace, ex[0], ey[1], ez[2])
    largest = parts.index(max(parts))
    if largest == 0:
        components = (1 + trace, ey[2] - ez[1], ez[0] - ex[2], ex[1] - ey[0])
    elif largest == 1:
        components = (ey[2] - ez[1], 1 + 2 * ex[0] - trace, ex[1] + ey[0], ez[0] + ex[2])
    elif largest == 2:
        components = (ez[0] - ex[2], ex[1] + ey[0], 1 + 2 * ey[1] - trace, ey[2] + ez[1])
    else:
        components = (ex[1] - ey[0], ez[0] + ex[2], ey[2] + ez[1], 1 + 2 * ez[2] - trace)
    w, x, y, z = unit(components)
    return w, x, y, z
