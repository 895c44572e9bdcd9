"""Vectors, rotations and angles on plain floats: for three numbers arrays would be slower.

Frames are REP 103: body x ahead, y left, z up; world x east, y north, z up. Quaternions are w, x, y, z, body to world.
"""

from math import asin, atan2, cos, degrees, fmod, hypot, radians, sin, sqrt

from lbr.messages.units import Quaternion, Vector

Matrix = tuple[Vector, Vector, Vector]
IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
NORTH_DEG = 90.0


def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    ax, ay, az = a
    bx, by, bz = b
    return (ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)


def norm(a: Vector) -> float:
    """Return the length."""
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scaled(a: Vector, factor: float) -> Vector:
    """Return a vector `factor` times as long."""
    return (a[0] * factor, a[1] * factor, a[2] * factor)


def times(matrix: Matrix, a: Vector) -> Vector:
    """Return the product of a matrix, by its rows, and a vector."""
    x, y, z = a
    (a0, a1, a2), (b0, b1, b2), (c0, c1, c2) = matrix
    return (a0 * x + a1 * y + a2 * z, b0 * x + b1 * y + b2 * z, c0 * x + c1 * y + c2 * z)


def rotation(roll_deg: float, pitch_deg: float, yaw_deg: float) -> Matrix:
    """Return the matrix that turns about x, then y, then z, each about the fixed axes (REP 103)."""
    cr, sr = cos(radians(roll_deg)), sin(radians(roll_deg))
    cp, sp = cos(radians(pitch_deg)), sin(radians(pitch_deg))
    cy, sy = cos(radians(yaw_deg)), sin(radians(yaw_deg))
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def axis_map(axes: str) -> Matrix:
    """Return the rotation for `axes`, such as `-y+x+z`: the body's x, y and z, each as an axis of the sensor.

    Raise ValueError if they are not three different axes that make a right-handed frame.
    """
    rows = [_axis(axes[at], axes[at + 1]) for at in (0, 2, 4)]
    x, y, z = rows
    if cross(x, y) != z:
        raise ValueError(f"axes '{axes}' are no right-handed frame; '+x+y+z' is one, '+x-y-z' another")
    return (x, y, z)


def from_euler(roll_rad: float, pitch_rad: float, yaw_rad: float) -> Quaternion:
    """Return the quaternion of roll, pitch and yaw."""
    cr, sr = cos(roll_rad / 2), sin(roll_rad / 2)
    cp, sp = cos(pitch_rad / 2), sin(pitch_rad / 2)
    cy, sy = cos(yaw_rad / 2), sin(yaw_rad / 2)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def to_euler(q: Quaternion) -> Vector:
    """Return roll, pitch and yaw of a quaternion of length 1, radians; at a pitch of 90 degrees roll is arbitrary."""
    w, x, y, z = q
    roll = atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    return (roll, pitch, atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def turned_about_up(q: Quaternion, yaw_rad: float) -> Quaternion:
    """Return a quaternion turned anticlockwise about the world's vertical."""
    c, s = cos(yaw_rad / 2), sin(yaw_rad / 2)
    w, x, y, z = q
    return (c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w)


def level(up: Vector) -> Quaternion:
    """Return the quaternion, with yaw 0, of a body with this upward vector."""
    return from_euler(atan2(up[1], up[2]), atan2(-up[0], hypot(up[1], up[2])), 0.0)


def compass_yaw_deg(field: Vector, up: Vector) -> float | None:
    """Return the body's yaw from magnetic east by a field and the unit vector up; None where the field is vertical."""
    east = cross(field, up)
    length = norm(east)
    if length < 1e-6 * (norm(field) or 1.0):
        return None
    north_ahead = field[0] - dot(field, up) * up[0]
    return degrees(atan2(north_ahead, east[0]))


def wrapped_deg(angle_deg: float) -> float:
    """Return an angle within -180 to 180 degrees."""
    folded = fmod(angle_deg + 180.0, 360.0)
    return folded - 180.0 if folded > 0.0 else folded + 180.0


def heading_deg(yaw_deg: float) -> float:
    """Return the compass heading, clockwise from north, of a yaw anticlockwise from east; at least 0, less than 360."""
    heading = fmod(NORTH_DEG - yaw_deg, 360.0)
    if heading < 0.0:
        heading += 360.0
    return 0.0 if heading >= 360.0 else heading


def _axis(sign: str, name: str) -> Vector:
    value = -1.0 if sign == "-" else 1.0
    x, y, z = (value if name == axis else 0.0 for axis in "xyz")
    return (x, y, z)
