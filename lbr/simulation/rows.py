"""What device rows may set for their emulated twins."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.simulation.faults import Mpu9150Faults, RoboteqFaults, UltrasonicFaults

Sense = Literal[-1, 1]
Board = Literal["arduino", "parallax"]
Fuse = Annotated[int, Meta(ge=0, le=255)]


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
    sensitivity: tuple[Fuse, Fuse, Fuse] = (176, 178, 166)
