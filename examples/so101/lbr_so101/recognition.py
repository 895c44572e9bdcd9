"""The recognition of a bus of STS3215: ids 1 to 12 are asked for their model number, without any write."""

from lbr.capability.recognition import Seen, SerialHandshake
from lbr.drivers.servos.protocol1 import packet
from lbr_so101 import table

IDS = range(1, 13)
STS3215 = 777


def seen(heard: bytes) -> Seen | None:
    """Return the servos that answered with this model number."""
    answers = packet.StatusParser().feed(heard)
    found = sorted(
        {one.id for one in answers if len(one.params) == 2 and int.from_bytes(one.params, "little") == STS3215}
    )
    return Seen(what=f"bus of {len(found)} Feetech STS3215: ids {', '.join(map(str, found))}") if found else None


HANDSHAKE = SerialHandshake(
    baud=1_000_000,
    questions=tuple(packet.read(servo, table.MODEL.address, 2) for servo in IDS),
    gap_s=0.008,
    listen_s=0.06,
    whole=True,
    seen=seen,
)
