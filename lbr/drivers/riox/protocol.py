"""The answers of a RIOX, `NAME=number:number:…`, as measurements. No I/O."""

import re
from math import hypot

from lbr.drivers.echoed_lines import Value
from lbr.drivers.inertial import HIGHEST, LOWEST, RAD_PER_DEG, STANDARD_GRAVITY_MPS2, Counts, scaled
from lbr.drivers.riox import RioxSettings
from lbr.messages.imu import ImuSample
from lbr.messages.units import Quaternion

MOTION, ORIENTATION = "ML", "QO"
LENGTHS = {MOTION: 10, ORIENTATION: 4}
ECHOES = {b"?ML": MOTION, b"?QO": ORIENTATION}
LENGTH_TOLERANCE = 0.1


def counts_of(value: Value) -> tuple[int, ...] | None:
    """Return the numbers of an answer: for `ML` acceleration, temperature, rotation and field, for `QO` w, x, y, z.

    None: they are not those of such an answer.
    """
    if not _COUNTS.fullmatch(value.text):
        return None
    counts = tuple(map(int, value.text.split(":")))
    whole = len(counts) == LENGTHS.get(value.name) and all(LOWEST <= count <= HIGHEST for count in counts)
    return counts if whole else None


def to_sample(c: tuple[int, ...], orientation: Quaternion | None, time_s: float, settings: RioxSettings) -> ImuSample:
    """Return the counts of an answer to `ML` in SI units."""
    accel: Counts = (c[0], c[1], c[2])
    gyro: Counts = (c[4], c[5], c[6])
    mag: Counts = (c[7], c[8], c[9])
    return ImuSample(
        valid=True,
        time_s=time_s,
        accel_mps2=scaled(accel, STANDARD_GRAVITY_MPS2 / settings.accel_lsb_per_g),
        gyro_rps=scaled(gyro, RAD_PER_DEG / settings.gyro_lsb_per_dps),
        mag_ut=scaled(mag, settings.mag_ut_per_lsb) if any(mag) else None,
        temperature_c=c[3] / settings.temperature_lsb_per_c + settings.temperature_offset_c,
        orientation=orientation,
    )


def to_orientation(counts: tuple[int, ...], divisor: float) -> Quaternion | None:
    """Return the counts of an answer to `QO` at length 1; None if their length differs too much from `divisor`."""
    w, x, y, z = counts
    length = hypot(w, x, y, z)
    if not abs(length / divisor - 1.0) <= LENGTH_TOLERANCE:
        return None
    return (w / length, x / length, y / length, z / length)


_COUNTS = re.compile(r"-?\d{1,5}(?::-?\d{1,5})*", re.ASCII)
