"""Recognition of a Roboteq by its firmware, the answer to `?FID`; `~` and `!` are never sent."""

from lbr.capability.recognition import Seen, SerialHandshake
from lbr.drivers.echoed_lines import ReplyParser, Value, query
from lbr.drivers.roboteq.protocol import is_inertial_unit


def seen(stream: bytes) -> Seen | None:
    """Return the motor controller with that firmware; an inertial unit of the same maker is another kind's."""
    for reply in ReplyParser().feed(stream):
        if isinstance(reply, Value) and reply.name == "FID" and "roboteq" in reply.text.lower():
            return None if is_inertial_unit(reply.text) else Seen(what=f"Roboteq motor controller, {reply.text}")
    return None


HANDSHAKE = SerialHandshake(baud=115_200, questions=(b"\r", query("FID")), gap_s=0.01, seen=seen)
