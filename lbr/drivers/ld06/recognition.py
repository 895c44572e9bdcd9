"""Recognition of an LD06: it sends by itself, three valid packets are enough, and nothing is written."""

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
"""Its proposed row, as if it sat in the middle and looked ahead; a person corrects its place."""


def seen(stream: bytes) -> Seen | None:
    """Return the lidar that sent these packets."""
    return (
        Seen(what="LD06 lidar", needs=(("range_sensor", SENSOR),))
        if len(PacketParser().feed(stream)) >= ENOUGH
        else None
    )


HANDSHAKE = SerialHandshake(baud=BAUD, listen_s=0.15, seen=seen)
