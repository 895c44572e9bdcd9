"""Recognition of a RIOX by the ten numbers of its answer to `?ML`."""

from lbr.capability.recognition import Seen, SerialHandshake
from lbr.drivers.riox.protocol import MOTION, Answer, ReplyParser, encode_query


def seen(stream: bytes) -> Seen | None:
    """Return the unit, if it answers with its motion."""
    answered = any(isinstance(one, Answer) and one.name == MOTION for one in ReplyParser().feed(stream))
    return Seen(what="Roboteq RIOX inertial unit") if answered else None


HANDSHAKE = SerialHandshake(baud=115_200, questions=(b"\r", encode_query(MOTION)), gap_s=0.01, seen=seen)
