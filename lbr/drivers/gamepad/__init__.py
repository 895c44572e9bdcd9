"""Gamepads of the kernel, by cable or radio: their kind and their settings."""

from msgspec import Struct

from lbr.capability.kind import Kind, OnDevice
from lbr.messages.gamepad import GamepadState
from lbr.messages.units import Name


class GamepadSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `gamepad`. The device's address is a path, or `input:` with radio address or name."""

    device: Name


KIND = Kind(
    name="gamepad",
    summary="what is held on a gamepad at the robot's own computer",
    family="driver",
    entry="lbr.drivers.gamepad.capability:Gamepad",
    settings=GamepadSettings,
    outputs={"state": GamepadState},
    device=OnDevice("gamepad", recognised="lbr.drivers.gamepad.recognition:HANDSHAKE"),
)
