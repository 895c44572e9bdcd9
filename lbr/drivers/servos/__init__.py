"""The common part of drivers of servo buses: settings, kind, the gate for setpoints, torque, guard, slow release.

Most servos report their torque, goal and limits. The package of their driver has the bus, the units of its numbers, and
a program that releases the servos after its death.

    class StsSettings(ServosSettings, frozen=True, kw_only=True, forbid_unknown_fields=True):
        on_estop: Literal["hold", "release"] = "hold"

    KIND = servos_kind("feetech", "a bus of Feetech STS servos", "my_sts.driver:Sts", StsSettings)

    class Sts(RegisterServos[StsSettings, StsBus]):
        def connect(self, device, urgent):
            line = open_servo_line(device, self.ctx.settings.baud, MARGIN_S)
            return ServoLink(bus=StsBus(line, urgent=urgent), model=StsModel(), guard=…, recovery=…)

`contract` describes the bus and the model. See docs/servo_drivers.md.
"""

from collections.abc import Mapping
from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.kind import Command, Kind, OnDevice, Rows
from lbr.capability.word import Word
from lbr.messages.joints import Joint
from lbr.messages.servos import RecoverServos, ServoSetpoint, ServosState
from lbr.messages.system import AcknowledgeS
from lbr.messages.units import Name, basic

NO_PORTS: Mapping[str, type[Struct]] = {}


class ServosSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The settings of every driver of servos."""

    device: Name
    baud: Annotated[int, Meta(ge=4800, le=4_000_000)] = 1_000_000
    sweep_hz: Annotated[float, Meta(ge=0.0, le=250.0, description="rounds of the poller per second at most")] = 100.0
    rest_hz: Annotated[
        float, Meta(ge=8.0, le=250.0, description="rounds per second while no servo moves: a place is good for 0.25 s")
    ] = 10.0
    still_rad: Annotated[float, Meta(ge=0.0, le=0.5, description="a servo within this of its place does not move")] = (
        0.02
    )
    still_load: Annotated[
        float, Meta(ge=0.0, le=1.0, description="a load within this of what it was has not changed")
    ] = 0.15
    setpoint_valid_s: Annotated[float, Meta(ge=0.02, le=0.25)] = 0.1
    hold_s: Annotated[
        float,
        basic("joints", "Joints stay on", ge=0.0, le=3600.0, description="how long servos without a sender hold"),
    ] = 30.0
    release_s: Annotated[
        float, basic("joints", "Then give way", ge=0.1, le=60.0, description="how long their torque then fades")
    ] = 5.0
    acknowledge_s: AcknowledgeS = 1.0
    on_close: Annotated[
        Literal["hold", "release"],
        Meta(description="at an orderly end: hold, then release slowly; or at once"),
    ] = "hold"
    guard: bool = True
    guard_silence_ms: Annotated[
        int, Meta(ge=60, le=2000, description="a driver silent for longer is killed while a servo has torque")
    ] = 500


class RegisterServosSettings(ServosSettings, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The settings of drivers whose servos report their torque, their goal and their limits."""

    sweep_hz: Annotated[float, Meta(ge=1.0, le=250.0, description="rounds of the poller per second at most")] = 100.0
    on_estop: Annotated[
        Literal["hold", "release"],
        basic("joints", "Emergency stop", description="the emergency stop: hold still, or release at once"),
    ] = "hold"


def servos_kind(
    name: str,
    summary: str,
    entry: str | type,
    settings: type[ServosSettings],
    *,
    device: str = "",
    recognised: str = "",
    outputs: Mapping[str, type[Struct]] = NO_PORTS,
    commands: Mapping[str, type[Struct] | Command] = NO_PORTS,
    replies: Mapping[str, type[Struct]] = NO_PORTS,
    words: tuple[Word, ...] = (),
) -> Kind:
    """Return the kind of a driver of servos; its device rows are of type `device`, by default its name."""
    return Kind(
        name=name,
        summary=summary,
        family="driver",
        entry=entry,
        settings=settings,
        setpoints={"setpoint": ServoSetpoint},
        outputs={"state": ServosState, **outputs},
        commands={"recover": RecoverServos, **commands},
        replies=replies,
        words=words,
        moves=True,
        device=OnDevice(device or name, line="polled", recognised=recognised),
        rows=(Rows(Joint, where={"bus": "device"}),),
    )
