"""Recognition of an MPU-9150: by its register WHO_AM_I."""

from lbr.capability.recognition import I2cHandshake, Read, Seen
from lbr.drivers.mpu9150 import registers


def seen(read: Read) -> Seen | None:
    """Return the unit, if WHO_AM_I is that of an MPU-9150."""
    return Seen(what="MPU-9150 inertial unit") if read(registers.WHO_AM_I, 1)[0] == registers.OWN_ID else None


HANDSHAKE = I2cHandshake(addresses=(0x68, 0x69), seen=seen)
