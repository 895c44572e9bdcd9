"""Recognition of a gamepad by the keys and axes that the kernel lists for it; it is not opened."""

from lbr.capability.recognition import NameHandshake, Seen


def seen(name: str) -> Seen:
    """Return the gamepad of that name."""
    return Seen(what=f"gamepad, {name}")


HANDSHAKE = NameHandshake(place="gamepad", seen=seen)
