"""Registers of the MPU-9150 and of the AK8975 inside it, and the meaning of their bytes. No I/O.

From the MPU-9150 register map (RM-MPU-9150A) and the AK8975 datasheet.
"""

import struct
from dataclasses import dataclass

from lbr.drivers.inertial import RAD_PER_DEG, STANDARD_GRAVITY_MPS2, Counts, scaled
from lbr.drivers.mpu9150 import Mpu9150Settings
from lbr.messages.units import Vector

ADDRESS = 0x68
SAMPLE_RATE_DIVIDER = 0x19  # and after it: low-pass, gyro range, accelerometer range
BYPASS = 0x37
MOTION = 0x3B
USER_CONTROL = 0x6A
POWER = 0x6B
WHO_AM_I = 0x75
MOTION_BYTES = 14
RESET = 0x80
AWAKE = 0x01  # clocked by the gyro, which is steadier than the oscillator used after a reset

OWN_ID = 0x68
OTHERS = {
    0x00: "nothing",
    0x70: "an MPU-6500",
    0x71: "an MPU-9250",
    0x73: "an MPU-9255",
    0x74: "an MPU-9515",
    0xFF: "nothing",
}
LOWPASS = {188: 1, 98: 2, 42: 3, 20: 4, 10: 5, 5: 6}

COMPASS_ADDRESS = 0x0C
COMPASS_ID = 0x00
COMPASS_READING = 0x02  # ST1, six bytes of data, ST2
COMPASS_READING_BYTES = 8
COMPASS_MODE = 0x0A
COMPASS_FUSES = 0x10
COMPASS_OWN_ID = 0x48
OFF, SINGLE, FUSES = 0x00, 0x01, 0x0F
CONVERSION_S = 0.0075
_READY, _DATA_ERROR, _OVERFLOW = 0x01, 0x04, 0x08
_MICROTESLA = 0.3
_FARTHEST = 4096

_MOTION = struct.Struct(">7h")
_READING = struct.Struct("<B3hB")


@dataclass(frozen=True, slots=True)
class Units:
    """The worth of one count, by the ranges set."""

    gyro_rps: float
    accel_mps2: float


@dataclass(frozen=True, slots=True)
class MagneticField:
    """One reading of the compass: microtesla along the accelerometer's axes, or the reason for none."""

    microtesla: Vector | None
    trouble: str = ""


def units(settings: Mpu9150Settings) -> Units:
    """Return the worth of one count: 131 are one degree per second at 250, 16384 one gravity at 2."""
    return Units(
        gyro_rps=RAD_PER_DEG * settings.gyro_range_dps / (250 * 131.0),
        accel_mps2=STANDARD_GRAVITY_MPS2 * settings.accel_range_g / (2 * 16384.0),
    )


def configuration(settings: Mpu9150Settings) -> dict[int, bytes]:
    """Return the registers of a unit at work, in the order in which they are written.

    It measures every millisecond at any sample rate, so the newest reading is never old. Bypass needs both registers,
    and lets the compass answer on the same bus.
    """
    gyro = (250, 500, 1000, 2000).index(settings.gyro_range_dps)
    accel = (2, 4, 8, 16).index(settings.accel_range_g)
    return {
        POWER: bytes((AWAKE,)),
        SAMPLE_RATE_DIVIDER: bytes((0, LOWPASS[settings.lowpass_hz], gyro << 3, accel << 3)),
        USER_CONTROL: b"\x00",
        BYPASS: b"\x02",
    }


def decode_motion(burst: bytes) -> tuple[int, ...]:
    """Return the 14 bytes as counts: acceleration, temperature, rotation; big endian."""
    return _MOTION.unpack(burst)


def temperature_c(count: int, offset_c: float) -> float:
    """Return the temperature; 340 counts are a kelvin."""
    return count / 340.0 + offset_c


def name_of(identity: int) -> str:
    """Return the name of the chip with an identity other than an MPU-9150's."""
    return OTHERS.get(identity, "something else")


def sensitivity(fuses: bytes) -> Vector | None:
    """Return microtesla per count of each compass axis, from the factory's fuses; None if they are not burnt."""
    if len(fuses) != 3 or not any(fuses) or all(fuse == 0xFF for fuse in fuses):
        return None
    x, y, z = (_MICROTESLA * ((fuse - 128) / 256.0 + 1.0) for fuse in fuses)
    return (x, y, z)


def decode_field(reading: bytes, unit: Vector) -> MagneticField | None:
    """Decode the eight bytes from ST1 to ST2, little endian; None while there is no new reading."""
    ready, x, y, z, status = _READING.unpack(reading)
    if not ready & _READY:
        return None
    if status & _OVERFLOW:
        return MagneticField(None, "the field is too strong to measure; is there a magnet or a motor nearby?")
    if status & _DATA_ERROR:
        return MagneticField(None, "the compass could not be read out: data error")
    if not max(abs(x), abs(y), abs(z)) <= _FARTHEST:
        return MagneticField(None, "the compass reads more than it can count to")
    # the compass is mounted turned: its x is the accelerometer's y, its y the x, its z points down
    return MagneticField((y * unit[1] + 0.0, x * unit[0] + 0.0, -z * unit[2] + 0.0))


def motion(counts: tuple[int, ...], unit: Units) -> tuple[Vector | None, Vector | None]:
    """Return acceleration and rotation in SI units; a value at the end of its range counts as not measured."""
    accel: Counts = (counts[0], counts[1], counts[2])
    gyro: Counts = (counts[4], counts[5], counts[6])
    return scaled(accel, unit.accel_mps2), scaled(gyro, unit.gyro_rps)
