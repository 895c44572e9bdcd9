"""Recognition of a RIOX: by the ten numbers that it answers to `?ML`."""

from lbr.capability.recognition import Seen, SerialHandshake
from lbr.drivers.riox.protocol import MOTION, Answer, ReplyParser, encode_query


def seen(heard: bytes) -> Seen | None:
    """Return the unit whose motion answers."""
    told = any(isinstance(one, Answer) and one.name == MOTION for one in ReplyParser().feed(heard))
    return Seen(what="Roboteq RIOX inertial unit") if told else None


HANDSHAKE = SerialHandshake(baud=115_200, questions=(b"\r", encode_query(MOTION)), gap_s=0.01, seen=seen)
