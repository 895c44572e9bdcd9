"""What device rows may set for their emulated twins."""

from typing import Literal

from msgspec import Struct

from lbr.simulation.faults import RoboteqFaults, UltrasonicFaults

Sense = Literal[-1, 1]
Board = Literal["arduino", "parallax"]


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
