"""The recognition of a RoboClaw: by the version that it reports at its first address."""

from lbr.capability.recognition import Seen, SerialHandshake
from lbr_roboclaw import protocol

ADDRESS = 0x80


def seen(heard: bytes) -> Seen | None:
    """Return the controller, if its version and the check bytes are in the answer."""
    for start in range(len(heard)):
        version = protocol.answered(ADDRESS, protocol.VERSION, heard[start:])
        if version is not None and b"roboclaw" in version.lower():
            return Seen(what=version.rstrip(b"\0\n").decode("ascii", "replace"), settings={"address": ADDRESS})
    return None


HANDSHAKE = SerialHandshake(baud=115_200, questions=(protocol.request(ADDRESS, protocol.VERSION),), seen=seen)
