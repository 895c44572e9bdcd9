"""RoboClaw 2x motor controllers by packet serial: their kind and their settings."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.drivers.wheels import WheelsSettings, wheels_kind


class Motor(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The wiring of one wheel's motor: forward times `direction` goes to `channel`."""

    channel: Literal[1, 2]
    direction: Literal[-1, 1] = 1
    max_power: Annotated[float, Meta(gt=0.0, le=1.0, description="limit, applied after everything else")] = 1.0


class RoboclawSettings(WheelsSettings, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `roboclaw`."""

    left: Motor = Motor(channel=1)
    right: Motor = Motor(channel=2)
    address: Annotated[int, Meta(ge=0x80, le=0x87, description="packet serial address, 128 to 135")] = 0x80
    baud: Literal[2400, 9600, 19200, 38400, 57600, 115200, 230400, 460800] = 115200
    reply_timeout_s: Annotated[float, Meta(ge=0.005, le=0.03, description="an answer later than this is lost")] = 0.02
    watchdog_ms: Literal[100, 200] = 200  # the controller counts in steps of 0.1 s
    tolerated_faults: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse wheels that share a channel, and tolerance for faults that must stop the robot."""
        if self.left.channel == self.right.channel:
            raise ValueError(f"left and right both use channel {self.left.channel}; give each wheel its own")
        if "emergency_stop" in self.tolerated_faults:
            raise ValueError("tolerated_faults must not hold `emergency_stop`")


KIND = wheels_kind(
    "roboclaw",
    "a RoboClaw motor controller driving two wheels",
    "lbr_roboclaw.driver:Roboclaw",
    RoboclawSettings,
    recognised="lbr_roboclaw.recognition:HANDSHAKE",
)
