"""Recognition of a RIOX by the ten numbers of its answer to `?ML`."""

from lbr.capability.recognition import Seen, SerialHandshake
from lbr.drivers.echoed_lines import ReplyParser, Value, query
from lbr.drivers.riox.protocol import MOTION, counts_of


def seen(stream: bytes) -> Seen | None:
    """Return the unit, if it answers with its motion."""
    values = (one for one in ReplyParser().feed(stream) if isinstance(one, Value) and one.name == MOTION)
    return Seen(what="Roboteq RIOX inertial unit") if any(map(counts_of, values)) else None


HANDSHAKE = SerialHandshake(baud=115_200, questions=(b"\r", query(MOTION)), gap_s=0.01, seen=seen)
