"""The contract of a camera: a descriptor to wait for, and pictures to take."""

from dataclasses import dataclass
from typing import Protocol

from lbr.bus import pictures
from lbr.capability.context import Device
from lbr.errors import DeviceError


@dataclass(frozen=True, slots=True)
class Picture:
    """The bytes of a JPEG file, and the time it was taken, by the monotonic clock."""

    data: bytes
    taken_s: float


class Source(Protocol):
    """An open camera. Every failure is a DeviceError that names the device row and the cure."""

    def fileno(self) -> int:
        """Return a descriptor that is readable while there is something to take."""

    def take(self) -> list[Picture]:
        """Return the received pictures, oldest first, broken ones too; never waits."""

    def pace(self, fps: float) -> None:
        """Set the approximate rate of pictures, if the device can change it while it streams; never fails."""

    def close(self) -> None:
        """Close the device; never fails."""


def check_controls(device: Device, wanted: dict[str, int | float], known: list[str]) -> None:
    """Refuse controls that the camera does not have."""
    unknown = sorted(set(wanted) - set(known))
    if unknown:
        there = ", ".join(sorted(known)) or "none"
        raise DeviceError(f"device '{device.name}' has no control {', '.join(unknown)}; it has {there}")


def usable(picture: Picture) -> Picture | None:
    """Return a picture without the zeros that some cameras append; None if it is incomplete or too large to send."""
    data = picture.data.rstrip(b"\0")
    if not pictures.is_whole(data) or len(data) > pictures.MOST_BYTES:
        return None
    return Picture(data, picture.taken_s)
