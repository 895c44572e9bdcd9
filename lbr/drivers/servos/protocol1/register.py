"""A number in a servo's control table: its address, its range, its sign. No I/O."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Register:
    """The address, size, writable range and unit of a number; `lowest` None: read only."""

    name: str
    address: int
    size: int
    lowest: int | None
    highest: int
    unit: str

    @property
    def writable(self) -> bool:
        """Return whether it can be written."""
        return self.lowest is not None

    def encode(self, value: int) -> bytes:
        """Return the bytes to write; raise ValueError with the allowed range."""
        if self.lowest is None:
            raise ValueError(f"{self.name} can only be read")
        if not self.lowest <= value <= self.highest:
            raise ValueError(f"{self.name} {value} is outside {self.lowest}..{self.highest}")
        return value.to_bytes(self.size, "little")

    def decode(self, block: bytes, first: int = 0) -> int:
        """Return its value from a block that was read from address `first` on."""
        start = self.address - first
        return int.from_bytes(block[start : start + self.size], "little")


def sign_magnitude(raw: int, bit: int) -> int:
    """Return the value of a number with a sign bit and a magnitude below it; minus zero is zero."""
    magnitude = raw & ((1 << bit) - 1)
    return -magnitude if raw >> bit & 1 else magnitude


def as_sign_magnitude(value: int, bit: int) -> int:
    """Return the raw form of a number with a sign bit."""
    if abs(value) >= 1 << bit:
        raise ValueError(f"{value} is outside {1 - (1 << bit)}..{(1 << bit) - 1}")
    return abs(value) | (1 << bit if value < 0 else 0)
