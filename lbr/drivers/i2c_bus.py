"""The i2c bus as drivers need it, whatever is behind it."""

from collections.abc import Sequence
from typing import Any, Protocol


class Bus(Protocol):
    """The calls of `smbus2.SMBus` that drivers use; each raises OSError, with an errno, if it did not succeed."""

    def read_byte_data(self, i2c_addr: int, register: int) -> int:
        """Return one register."""

    def read_word_data(self, i2c_addr: int, register: int) -> int:
        """Return two registers, the low byte first."""

    def read_i2c_block_data(self, i2c_addr: int, register: int, length: int) -> list[int]:
        """Return up to 32 registers of one instant."""

    def write_byte_data(self, i2c_addr: int, register: int, value: int) -> None:
        """Set one register."""

    def write_i2c_block_data(self, i2c_addr: int, register: int, data: Sequence[int]) -> None:
        """Set up to 32 registers."""

    def i2c_rdwr(self, *i2c_msgs: Any) -> None:
        """Do one transaction of several messages."""

    def close(self) -> None:
        """Close the device."""
