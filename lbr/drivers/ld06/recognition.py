"""Recognition of an LD06: it talks by itself; three sound packets are enough, and nothing is sent."""

from lbr.capability.recognition import Seen, SerialHandshake
from lbr.drivers.ld06.protocol import BAUD, PacketParser

ENOUGH = 3
SENSOR = {
    "name": "lidar",
    "kind": "lidar",
    "fov_rad": 6.2832,
    "min_m": 0.02,
    "max_m": 12.0,
    "rays": 360,
    "stop_m": None,
}
"""Its row, as if it sat in the middle and looked ahead; where it sits is for a person to correct."""


def seen(stream: bytes) -> Seen | None:
    """Return the lidar whose packets these are."""
    return (
        Seen(what="LD06 lidar", needs=(("range_sensor", SENSOR),))
        if len(PacketParser().feed(stream)) >= ENOUGH
        else None
    )


HANDSHAKE = SerialHandshake(baud=BAUD, listen_s=0.15, seen=seen)
