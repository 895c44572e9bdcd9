"""Messages of the UXA-90's main board (UIC) and of single servos behind it, besides those on `servos/*`."""

from math import radians
from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.servos import ServoId

MIDDLE = 127
"""The count of a SAM servo in the middle of its range."""
COUNT_RAD = radians(269.0 / 254.0)
"""The angle of a count: 0 to 254 are 269 degrees."""
LOWEST, HIGHEST = 1, 254
"""Legal targets; the line accepts 0, but it lies outside the known range of these servos."""

ControllerMode = Literal["unknown", "normal", "taking", "pc"]
Register = Literal[
    "position14", "gains", "runtime_gains", "integral_gain", "runtime_integral_gain", "speed", "runtime_speed",
    "overload", "boundary", "id", "baud", "digital_io",
]  # fmt: skip
Question = Literal[Register, "firmware", "serial", "zeros", "imu", "last_button"]
Byte = Annotated[int, Meta(ge=0, le=255)]


class TakeControlCommand(Struct, frozen=True, kw_only=True):
    """Make the main board pass servo packets on (PC control); this moves nothing."""


class InquireCommand(Struct, frozen=True, kw_only=True):
    """Ask a servo (`id`) for a register, or the main board about itself."""

    what: Question
    id: ServoId | None = None


class InquireReply(Struct, frozen=True, kw_only=True):
    """The answer as numbers, and as text for people."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    values: tuple[int, ...] = ()
    text: str = ""


class ConfigureCommand(Struct, frozen=True, kw_only=True):
    """Write a servo's register and read it back; needs the driver's setting `maintenance`."""

    what: Register
    id: ServoId
    values: Annotated[tuple[Byte, ...], Meta(min_length=1, max_length=2)]


class ControllerState(Struct, frozen=True, kw_only=True):
    """The main board: its mode, its versions, and the quality of the line.

    `trust`: positions are trusted now; else `reason`.
    """

    mode: ControllerMode
    firmware: str = ""
    serial: str = ""
    trust: bool = False
    reason: str = ""
    replies: int = 0
    missing: int = 0
    implausible: int = 0
    strays: int = 0
