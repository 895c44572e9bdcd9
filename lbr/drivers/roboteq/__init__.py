"""Roboteq SDC21xx two-channel motor controller on a serial line: its kind and its settings."""

import re
from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.drivers.wheels import WheelsSettings, wheels_kind

FaultName = Literal[
    "overheat",
    "overvoltage",
    "undervoltage",
    "short_circuit",
    "emergency_stop",
    "sensor_or_setup",
    "mosfet",
    "default_configuration",
]
Pattern = Annotated[str, Meta(max_length=200, description="regular expression in its answer; empty: any")]
Baud = Literal[9600, 19200, 38400, 57600, 115200]


class Wheel(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A wheel's motor: forward times `direction` goes to `channel`."""

    channel: Literal[1, 2]
    direction: Literal[-1, 1] = 1
    trim: Annotated[float, Meta(ge=0.5, le=1.5, description="factor that makes the wheels run alike")] = 1.0
    max_power: Annotated[float, Meta(gt=0.0, le=1.0, description="limit, applied after everything else")] = 1.0


class RoboteqSettings(WheelsSettings, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `roboteq`."""

    left: Wheel = Wheel(channel=1)
    right: Wheel = Wheel(channel=2)
    watchdog_ms: Annotated[int, Meta(ge=50, le=250, description="the controller's own watchdog, `^RWD`")] = 200
    reply_timeout_s: Annotated[float, Meta(ge=0.005, le=0.1, description="an answer later than this is lost")] = 0.03
    echo: bool = True
    mixing_mode: Annotated[int, Meta(ge=0, le=9, description="what `~MXMD` must answer; 0 is separate")] | None = 0
    firmware: Pattern = "(?i)roboteq"
    model: Pattern = ""
    tolerated_faults: tuple[FaultName, ...] = ("default_configuration",)
    baud: Baud = 115200

    def __post_init__(self) -> None:
        """Refuse wheels that share a channel, and tolerance of a fault that must stop the robot."""
        if self.left.channel == self.right.channel:
            raise ValueError(f"left and right both use channel {self.left.channel}; give each wheel its own")
        if "emergency_stop" in self.tolerated_faults:
            raise ValueError("tolerated_faults must not hold `emergency_stop`")
        for field, pattern in (("firmware", self.firmware), ("model", self.model)):
            try:
                re.compile(pattern)
            except re.error as err:
                raise ValueError(f"{field} is not a regular expression: {err}") from err

    def doubts(self) -> tuple[str, ...]:
        """Return warnings about settings that are allowed but usually wrong: motors mounted mirrored need opposite
        directions."""
        if self.left.direction != self.right.direction:
            return ()
        text = (
            f"both wheels have direction {self.left.direction}; on a base whose motors are mounted mirrored one has -1"
        )
        return (f"{text}, or it turns when it is to drive ahead: try `/r/0.1/0` with the wheels off the floor",)


KIND = wheels_kind(
    "roboteq",
    "Roboteq SDC21xx motor controller driving two wheels",
    "lbr.drivers.roboteq.capability:Roboteq",
    RoboteqSettings,
    recognised="lbr.drivers.roboteq.recognition:HANDSHAKE",
)
