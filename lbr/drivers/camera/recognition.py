"""Recognition of a camera by the kernel's name of its video node; the node is not opened, and may be in use."""

from lbr.capability.recognition import NameHandshake, Seen


def seen(name: str) -> Seen:
    """Return the camera of that name."""
    return Seen(what=f"camera, {name}")


HANDSHAKE = NameHandshake(place="video", seen=seen)
