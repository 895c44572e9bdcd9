"""Recognition of a UPS PIco by a plausible source and battery voltage; its registers are only read."""

from lbr.capability.recognition import I2cHandshake, Read, Seen
from lbr.drivers.pico import registers
from lbr.errors import MalformedError

LEAST_V, MOST_V = 1.0, 6.0


def seen(read: Read) -> Seen | None:
    """Return the supply, if its numbers are plausible."""
    try:
        source = registers.source(read(registers.MODE, 1)[0])
        battery_v = registers.volts(int.from_bytes(read(registers.BATTERY, 2), "little"))
        firmware = read(registers.FIRMWARE, 1)[0]
    except MalformedError:
        return None
    if not LEAST_V <= battery_v <= MOST_V:
        return None
    return Seen(what=f"UPS PIco, firmware {firmware:x}, on {source}, battery {battery_v:.2f} V")


HANDSHAKE = I2cHandshake(addresses=(registers.STATUS_ADDRESS, 0x59), seen=seen)
