"""What device rows may set for their emulated twins."""

from collections.abc import Mapping
from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.simulation.dynamixel.timing import BusTiming
from lbr.simulation.faults import (
    CameraFaults,
    DynamixelFaults,
    InfraredFaults,
    Mpu9150Faults,
    PhidgetSpatialFaults,
    PicoFaults,
    RioxFaults,
    RoboteqFaults,
    UltrasonicFaults,
    Uxa90Faults,
)
from lbr.simulation.measured import Beam
from lbr.simulation.uxa90.firmware import Programme

Sense = Literal[-1, 1]
Board = Literal["arduino", "parallax"]
Scancode = (
    Annotated[int, Meta(ge=1, lt=2**32)]
    | Annotated[str, Meta(pattern="^0[xX][0-9a-fA-F]{1,8}$", description="the same in hexadecimal, such as 0x400021")]
)
Scale = Annotated[float, Meta(gt=0.0, le=1e6)]
Byte = Annotated[int, Meta(ge=0, le=255)]
Slot = Annotated[str, Meta(pattern="^[1-9][0-9]?$", description="the number of a main board's motion")]


class RoboteqRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How a `roboteq` device row says it is wired: a direction of -1 turns the wheel back for a positive command."""

    faults: RoboteqFaults = RoboteqFaults()
    left_channel: Literal[1, 2] = 1
    left_direction: Sense = -1
    right_direction: Sense = 1


class UltrasonicRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Which board an `ultrasonic_ring` device row means."""

    faults: UltrasonicFaults = UltrasonicFaults()
    board: Board = "arduino"


class Mpu9150Row(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where an `mpu9150` device row's chip answers (0x69 with AD0 high), and its compass's fuses (ASA of x, y, z)."""

    faults: Mpu9150Faults = Mpu9150Faults()
    i2c_address: Literal[0x68, 0x69] = 0x68
    sensitivity: tuple[Byte, Byte, Byte] = (176, 178, 166)


class RioxRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How a `riox` device row's unit counts; `echo`: it repeats what it hears, until told otherwise."""

    faults: RioxFaults = RioxFaults()
    echo: bool = True
    gyro_lsb_per_dps: Scale = 32.75
    accel_lsb_per_g: Scale = 16384.0
    mag_ut_per_lsb: Scale = 0.3
    temperature_lsb_per_c: Scale = 340.0
    temperature_offset_c: float = 35.0
    quaternion_divisor: Scale = 16384.0
    euler_lsb_per_deg: Scale = 10.0


class BeamCodes(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The scancode that the dock sends on each beam, as a number or in hexadecimal; null: it has no such beam."""

    left: Scancode | None = "0x400021"
    right: Scancode | None = "0x400022"
    power: Scancode | None = "0x400024"

    def numbers(self) -> dict[Beam, int]:
        """Return the codes as numbers."""
        given: dict[Beam, Scancode | None] = {"left": self.left, "right": self.right, "power": self.power}
        return {beam: int(code, 16) if isinstance(code, str) else code for beam, code in given.items() if code}


class InfraredRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What an `infrared` device row's receiver hears of the dock; `protocol` is the kernel's number, 7 for Sony-15."""

    faults: InfraredFaults = InfraredFaults()
    codes: BeamCodes = BeamCodes()
    protocol: Annotated[int, Meta(ge=0, le=63)] = 7


class PhidgetSpatialRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How many samples a `phidget_spatial` device row's unit sends at once."""

    faults: PhidgetSpatialFaults = PhidgetSpatialFaults()
    burst: Annotated[int, Meta(ge=1, le=8)] = 2


class CameraRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where a `camera` device row's camera sits: a name of the world's setting `cameras`.

    Empty: the one that the device's name ends with, or else the first.
    """

    faults: CameraFaults = CameraFaults()
    mount: str = ""


class PicoRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where a `pico` device row's supply answers, and how its own battery is.

    `relay_on` is what its relay holds while the motors have power, as they have at the beginning.
    """

    faults: PicoFaults = PicoFaults()
    i2c_address: Literal[0x69, 0x59] = 0x69
    relay_on: Literal[0, 1] = 1
    battery_v: Annotated[float, Meta(ge=0.0, le=5.0)] = 4.1
    temperature_c: Annotated[int, Meta(ge=0, le=99)] = 33


class DynamixelRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What hangs on a `dynamixel` device row's bus, and how fast it is; `usb2ax` is a dongle's firmware, null: none.

    `return_delay` is what the servos' registers hold at first, in 2 us; 250 as they leave the factory.
    `goal_switches_on`: whoever gets a goal gets torque too, as some users say of theirs and the manual does not.
    """

    faults: DynamixelFaults = DynamixelFaults()
    ids: Annotated[tuple[Annotated[int, Meta(ge=0, le=252)], ...], Meta(min_length=1, max_length=100)] = tuple(
        range(1, 19)
    )
    usb2ax: Literal[4, 5] | None = 5
    return_delay: Annotated[int, Meta(ge=0, le=254)] = 250
    goal_switches_on: bool = False
    timing: BusTiming = BusTiming()


class Uxa90Row(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is at the other end of a `uxa90` device row's line, and how fast it is; `ids` are the servos that it has.

    `zeros` are its own zero of each servo, as the main board keeps them. `programmes` replace motions of the main board, by
    slot. `aborts`: PC control ends a motion; if not, it is ignored meanwhile.
    `reports_end`: a motion of the remote control is answered when it is over. `answers_fine`: so is a move of 14 bits, with
    the place. `imu_sum`: whether the sum of what the inertial unit says is right. A servo answers after `reply_ms` and up
    to `jitter_ms` more; PC control is there `settle_ms` after it was asked for. `trace`: all bytes heard and said, and
    each change of mode, go to a file beside the device's address, whose name ends in `.trace`.
    """

    faults: Uxa90Faults = Uxa90Faults()
    baud: Annotated[int, Meta(ge=4800, le=921_600)] = 115_200
    ids: Annotated[tuple[Annotated[int, Meta(ge=0, le=30)], ...], Meta(min_length=1)] = tuple(range(25))
    firmware: Annotated[tuple[Byte, ...], Meta(min_length=2, max_length=2)] = (0xC9, 0x00)
    serial: Annotated[str, Meta(pattern="^[0-9]{13}$")] = "6012000010005"
    zeros: Annotated[tuple[Annotated[int, Meta(ge=0, le=254)], ...], Meta(min_length=31, max_length=31)] = (
        *(130, 129, 129, 131, 38, 214, 85, 172, 128, 132, 131, 130, 87, 169, 134, 125),
        *(128, 126, 215, 43, 127, 127, 127, 130, 125, 1, 127, 127, 127, 127, 127),
    )
    programmes: dict[Slot, Programme] = {}
    aborts: bool = True
    reports_end: bool = True
    answers_fine: bool = False
    imu_sum: bool = True
    imu_lsb_per_g: Scale = 256.0
    reply_ms: Annotated[float, Meta(ge=0.0, le=250.0)] = 1.0
    jitter_ms: Annotated[float, Meta(ge=0.0, le=250.0)] = 0.3
    saving_ms: Annotated[float, Meta(ge=0.0, le=250.0, description="how much longer it takes to save a register")] = (
        30.0
    )
    settle_ms: Annotated[float, Meta(ge=0.0, le=5000.0)] = 50.0
    trace: bool = False


DEVICE_ROWS: Mapping[str, type[Struct]] = {
    "roboteq": RoboteqRow,
    "ultrasonic_ring": UltrasonicRow,
    "mpu9150": Mpu9150Row,
    "phidget_spatial": PhidgetSpatialRow,
    "riox": RioxRow,
    "pico": PicoRow,
    "infrared": InfraredRow,
    "camera": CameraRow,
    "dynamixel": DynamixelRow,
    "uxa90": Uxa90Row,
}
"""What a device row of each type that has a twin may set, in whichever world."""
