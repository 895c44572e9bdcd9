"""The line to a device, as a driver's protocol needs it; `SerialLine` is one."""

from typing import Protocol


class ByteLine(Protocol):
    """The bytes to and from a device."""

    def read(self, wait_s: float = 0.0) -> bytes:
        """Return the received bytes, waiting `wait_s` at most for the first."""

    def write(self, data: bytes) -> int:
        """Write as much as the line takes at once; return how many bytes that was."""

    def drop_output(self) -> None:
        """Discard the output that has not left yet."""

    def drop_input(self) -> None:
        """Discard the input that was not read yet."""

    def close(self) -> None:
        """Close the device."""
