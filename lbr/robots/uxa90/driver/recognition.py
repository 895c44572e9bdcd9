"""Recognition of a UXA-90's main board by its firmware's number; control is not taken, so no servo notices."""

from lbr.capability.recognition import Seen, SerialHandshake
from lbr.robots.uxa90.driver import frames


def seen(stream: bytes) -> Seen | None:
    """Return the main board, if it answers with its firmware."""
    for frame in frames.FrameParser().feed(stream)[0]:
        if frame.type == frames.FIRMWARE and len(frame.contents) == frames.QUESTIONS["firmware"][1]:
            return Seen(what=f"UXA-90, firmware {frame.contents[0]}.{frame.contents[1]}")
    return None


HANDSHAKE = SerialHandshake(baud=115_200, questions=(frames.ask("firmware"),), listen_s=0.15, seen=seen)
