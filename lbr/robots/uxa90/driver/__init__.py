"""The serial line of a UXA-90: its main board (UIC) and the SAM servos behind it; its kind and its settings."""

from typing import Annotated, Literal

from msgspec import Meta, Struct, field

from lbr.capability.kind import Command
from lbr.capability.word import Word
from lbr.drivers.servos import ServosSettings, servos_kind
from lbr.messages.imu import ImuSample
from lbr.messages.system import AcknowledgeS
from lbr.messages.units import basic
from lbr.robots.uxa90.driver.messages import (
    ConfigureCommand,
    ControllerState,
    InquireCommand,
    InquireReply,
    TakeControlCommand,
)

Slot = Annotated[int, Meta(ge=1, le=42)]


class ImuSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The rate of questions to the main board's inertial unit, and what its six bytes mean, not tried on a robot."""

    asked: Annotated[
        Literal["never", "simulated", "always"],
        Meta(description="whether it is asked; `simulated`: not on hardware"),
    ] = "never"
    hz: Annotated[float, Meta(ge=1.0, le=20.0, description="how often, between two questions to servos")] = 10.0
    lsb_per_g: Annotated[float, Meta(gt=0.0, le=1e6, description="counts at rest, along the upward axis")] = 256.0
    gravity_sign: Annotated[Literal[-1, 1], Meta(description="-1: negative along the upward axis")] = 1
    order: Annotated[Literal["big", "little"], Meta(description="which byte of a number comes first")] = "big"
    sum: Annotated[bool, Meta(description="answers with a wrong sum are dropped")] = True


class Uxa90Settings(ServosSettings, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `uxa90`."""

    baud: Annotated[int, Meta(ge=4800, le=921_600)] = 115_200
    sweep_hz: Annotated[float, Meta(ge=0.0, le=50.0, description="position sweeps per second; 0 reads none")] = 20.0
    rest_hz: Annotated[
        float, Meta(ge=4.0, le=50.0, description="position sweeps while no servo moves: a place is good for 0.6 s")
    ] = 5.0
    on_estop: Annotated[
        Literal["hold", "break", "release"],
        basic("joints", "Emergency stop", description="the emergency stop: hold, short the motors, or release"),
    ] = "break"
    acknowledge_s: AcknowledgeS = 3.0
    """The limit for every servo to be read standing still: after a motion of the main board a second passes before any
    can be read."""
    reply_s: Annotated[float, Meta(ge=0.002, le=0.25, description="how long a servo's answer is waited for")] = 0.03
    together: Annotated[int, Meta(ge=1, le=25, description="this many servos are asked in one write")] = 5
    settle_s: Annotated[float, Meta(ge=0.0, le=5.0, description="from taking control to the first servo packet")] = 1.0
    trust: Annotated[
        Literal["never", "plausible", "always"],
        Meta(description="whether positions are believed: they lack id and checksum"),
    ] = "plausible"
    stored_by: Annotated[
        Literal["remote", "direct"],
        Meta(description="how the main board's motions start: as by remote control, or in PC control"),
    ] = "remote"
    slots: Annotated[tuple[Slot, ...], Meta(description="motions that may start; 33 switches off, 34 the mode")] = (
        *range(1, 15),
        21,
    )
    offsets: Annotated[
        dict[int, Annotated[int, Meta(ge=-60, le=60)]], Meta(description="counts added to each position of a servo")
    ] = field(default_factory=dict)
    maintenance: Annotated[bool, Meta(description="whether servos' registers may be written")] = False
    imu: ImuSettings = ImuSettings()

    def doubts(self) -> tuple[str, ...]:
        """Return a warning about a setting that is allowed but usually wrong: servos that are never read."""
        if self.sweep_hz:
            return ()
        text = (
            "sweep_hz is 0, so no servo is read: one that gets power late goes at once to where it was sent meanwhile"
        )
        return (f"{text}, with the torque that was asked for",)


KIND = servos_kind(
    "uxa90",
    "the serial line of a UXA-90: its main board and the SAM servos behind it",
    "lbr.robots.uxa90.driver.capability:Uxa90",
    Uxa90Settings,
    recognised="lbr.robots.uxa90.driver.recognition:HANDSHAKE",
    outputs={"controller": ControllerState, "imu": ImuSample},
    commands={
        "take_control": TakeControlCommand,
        "inquire": Command(InquireCommand, role="view"),
        "configure": Command(ConfigureCommand, role="admin"),
    },
    replies={"inquire": InquireReply, "configure": InquireReply},
    words=(
        Word(
            "pc",
            "take_control",
            "Have the main board pass servo packets on; done by itself before the first move",
        ),
        Word("/inquire/{what}", "inquire", "Ask the main board: firmware, serial, zeros, imu or last_button"),
        Word(
            "/inquire/{what}/{id}",
            "inquire",
            "Ask a servo: position14, gains, integral_gain, speed, overload, boundary or digital_io",
        ),
    ),
)
