"""Messages on `gamepad/*` and `teleop/*`: the input of a gamepad, and its effect on the robot."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.units import SpeedMps, TurnRps

Axis = Literal["left_x", "left_y", "right_x", "right_y", "left_trigger", "right_trigger", "dpad_x", "dpad_y"]
Button = Literal[
    "a", "b", "c", "x", "y", "z", "tl", "tr", "tl2", "tr2", "select", "start", "mode", "thumbl", "thumbr",
    "dpad_up", "dpad_down", "dpad_left", "dpad_right",
    "trigger", "thumb", "thumb2", "top", "top2", "pinkie", "base", "base2", "base3", "base4", "base5", "base6",
]  # fmt: skip
"""The names of Linux (BTN_A, BTN_TL …).

`tl` and `tr` are the shoulders; `trigger` to `base6` are the numbered buttons, from 1, of pads without a layout of
their own.
"""
Link = Literal["usb", "bluetooth", "other"]
Way = Annotated[float, Meta(ge=-1.0, le=1.0, description="-1 to 1 to the right and up; a trigger 0 to 1")]


class GamepadState(Struct, frozen=True, kw_only=True):
    """The input of a gamepad: how far each axis is pushed, which buttons are pressed.

    `silent_s`: since its last report; null: none yet. An unchanged pad is as silent as one out of range.
    """

    connected: bool
    name: str = ""
    link: Link = "other"
    axes: dict[Axis, Way] = {}
    pressed: tuple[Button, ...] = ()
    silent_s: float | None = None
    reason: str = ""


class TeleopState(Struct, frozen=True, kw_only=True):
    """The effect of a gamepad: whether the dead-man button is held, and the twist. `reason`: why it does not drive."""

    pad: bool
    dead_man: bool
    driving: bool
    vx_mps: SpeedMps = 0.0
    vy_mps: SpeedMps = 0.0
    wz_rps: TurnRps = 0.0
    line: str = ""
    reason: str = ""
    code: ReasonCode = ""
