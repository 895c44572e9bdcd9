"""The line to a device, as a driver's protocol needs it; `SerialLine` is one."""

from typing import Protocol


class ByteLine(Protocol):
    """The bytes to and from a device."""

    def read(self, wait_s: float = 0.0) -> bytes:
        """Return what has come in, waiting `wait_s` at most."""

    def write(self, data: bytes) -> int:
        """Hand over what the line takes at once and return how much."""

    def drop_output(self) -> None:
        """Throw away what has not left yet."""

    def drop_input(self) -> None:
        """Throw away what was not read yet."""

    def close(self) -> None:
        """Close the device."""
