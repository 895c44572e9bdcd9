"""Recognition of an infrared receiver by its kernel name; it is not opened."""

from lbr.capability.recognition import NameHandshake, Seen


def seen(name: str) -> Seen:
    """Return the receiver of that name."""
    return Seen(what=f"infrared receiver, {name}")


HANDSHAKE = NameHandshake(place="lirc", seen=seen)
