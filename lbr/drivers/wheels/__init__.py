"""The common part of drivers of wheels: settings, kind, the gate for setpoints, the guard, the capability.

A driver of another controller, in a package of its own, is a `WheelController` and three declarations:

    class OdriveSettings(WheelsSettings, frozen=True, kw_only=True, forbid_unknown_fields=True):
        baud: int = 115200

    KIND = wheels_kind("odrive", "an ODrive with two motors", "my_odrive.driver:Odrive", OdriveSettings)

    class Odrive(Wheels[OdriveSettings]):
        def connect(self, device, beat):
            return OdriveController(open_line(device, self.ctx.settings.baud), self.ctx.settings, self.ctx.clock, beat)

`contract.WheelController` describes such a controller. It drives the motors `left` and `right`; a driver of other
motors names them in `motors`:

        motors = ("front_left", "front_right", "rear_left", "rear_right")

See docs/drivers.md.
"""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.kind import Kind, OnDevice
from lbr.capability.word import Word
from lbr.messages.kinematics import Kinematics, Wheel
from lbr.messages.motors import MotorSetpoint, MotorsState
from lbr.messages.system import AcknowledgeS
from lbr.messages.units import Name


class EnableCommand(Struct, frozen=True, kw_only=True):
    """Let setpoints through to the motors, or hold zero."""

    enabled: bool


class WheelsSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The settings of every driver of wheels."""

    device: Name
    enabled: bool = True
    setpoint_valid_s: Annotated[float, Meta(ge=0.02, le=0.25)] = 0.1
    watchdog_ms: Annotated[int, Meta(ge=50, le=250, description="the controller's own watchdog")] = 200
    still_counts: Annotated[
        int, Meta(ge=0, le=20, description="an encoder within this of what it counted has not turned: edges flicker")
    ] = 2
    acknowledge_s: AcknowledgeS = 0.5
    guard: bool = True
    guard_silence_ms: Annotated[
        int, Meta(ge=60, le=250, description="a driver silent for longer is killed while a motor may turn")
    ] = 120


def wheels_kind(
    name: str,
    summary: str,
    entry: str | type,
    settings: type[WheelsSettings],
    device: str = "",
    *,
    recognised: str = "",
) -> Kind:
    """Return the kind of a driver of wheels; its device rows are of type `device`, by default its name."""
    return Kind(
        name=name,
        summary=summary,
        family="driver",
        entry=entry,
        settings=settings,
        setpoints={"setpoint": MotorSetpoint},
        outputs={"state": MotorsState},
        commands={"enable": EnableCommand},
        rows=(Kinematics, Wheel),
        moves=True,
        device=OnDevice(device or name, line="serial", recognised=recognised),
        words=(
            Word("enable", "enable", "Let the motors run again after disable", {"enabled": True}),
            Word(
                "disable", "enable", "Hold the motors at zero until enable, whatever is commanded", {"enabled": False}
            ),
        ),
    )
