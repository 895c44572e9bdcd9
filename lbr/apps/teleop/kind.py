"""The kind `gamepad_teleop`: its settings, ports and words."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.apps.motion_requests import motion_requests
from lbr.capability.kind import Kind, Rights, Wire
from lbr.messages.drive import GoalResult
from lbr.messages.gamepad import Button, GamepadState, TeleopState
from lbr.messages.system import ConsoleResult, LineCommand

Line = Annotated[str, Meta(min_length=1, max_length=250, description="a line of the console, such as /s/hello")]
ButtonOrNone = Button | Literal[""]
"""A button, or empty for none."""


class TeleopSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `gamepad_teleop`.

    The robot moves only while the button `dead_man` is held. `stop` stops whatever moves, always; `estop` latches the
    emergency stop. `lines`: console lines of other buttons.
    """

    dead_man: Button = "tl"
    stop: ButtonOrNone = "b"
    estop: ButtonOrNone = ""
    lines: Annotated[dict[Button, Line], Meta(max_length=30)] = {}
    speed_mps: Annotated[float, Meta(gt=0.0, le=10.0, description="with the stick all the way")] = 0.4
    turn_rps: Annotated[float, Meta(gt=0.0, le=20.0, description="with the stick all the way")] = 1.2
    sideways: Annotated[bool, Meta(description="left stick: any way; right stick alone: turns")] = False
    dead_zone: Annotated[float, Meta(ge=0.02, le=0.9, description="of a stick's way: less is rest")] = 0.12
    stale_s: Annotated[
        float, Meta(ge=0.15, le=1.0, description="a driver of the gamepad silent for longer is gone")
    ] = 0.2
    silent_s: Annotated[
        float, Meta(ge=0.5, le=60.0, description="a radio gamepad silent for longer may be out of range")
    ] = 2.0
    wireless: Annotated[bool, Meta(description="it has a radio: silence counts")] = False
    ttl_s: Annotated[float, Meta(ge=0.2, le=1.0, description="motion outlives this process for so long")] = 0.3

    def __post_init__(self) -> None:
        """Refuse a button with two meanings."""
        used = [one for one in (self.dead_man, self.stop, self.estop, *self.lines) if one]
        if twice := sorted({one for one in used if used.count(one) > 1}):
            raise ValueError(f"the button {twice[0]} is to be two things: give each its own")


_MOTION = motion_requests(
    "twist", "move", "turn", "heading", "halt", "play", "play_halt", "seek", "seek_halt", "stop_all"
)

KIND = Kind(
    name="gamepad_teleop",
    summary="drives by a gamepad while its dead-man button is held; its buttons send console lines",
    family="app",
    entry="lbr.apps.teleop.capability:Teleop",
    settings=TeleopSettings,
    inputs={"pad": GamepadState, "results": GoalResult},
    optional=("results",),
    outputs={"state": TeleopState},
    requests={**_MOTION.requests, "say": LineCommand},
    replies={"say": ConsoleResult},
    rights=Rights(serves=True),
    says="lines",
    wires={"pad": Wire("gamepad.state", 16), "results": Wire("result", 16), **_MOTION.wires},
)
