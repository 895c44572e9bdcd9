"""The emulated gamepad: its input, which is set like the faults of other devices, and its twin."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.twins import DeviceTwin
from lbr.simulation.faults import Faults, Probability

Press = Literal["a", "b", "x", "y", "tl", "tr", "select", "start", "mode", "thumbl", "thumbr"]
Push = Annotated[float, Meta(ge=-1.0, le=1.0, description="-1 to 1, to the right and up")]
Pull = Annotated[float, Meta(ge=0.0, le=1.0)]


class GamepadFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The input of a gamepad: pressed buttons, and how far the axes are pushed; `silent`: out of range."""

    pressed: tuple[Press, ...] = ()
    left_x: Push = 0.0
    left_y: Push = 0.0
    right_x: Push = 0.0
    right_y: Push = 0.0
    left_trigger: Pull = 0.0
    right_trigger: Pull = 0.0
    dpad_x: Push = 0.0
    dpad_y: Push = 0.0
    silent: bool = False
    garbage: Probability = 0.0
    half: Probability = 0.0


class GamepadRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The first state of a `gamepad` device row's pad."""

    faults: GamepadFaults = GamepadFaults()


TWIN = DeviceTwin(device="gamepad", row=GamepadRow, entry="lbr.simulation.devices.gamepad.twin:GamepadTwin")
