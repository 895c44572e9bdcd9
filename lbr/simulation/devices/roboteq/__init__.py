"""The emulated motor controller Roboteq SDC21xx: the settings of its device rows, its faults, and its twin."""

from typing import Literal

from msgspec import Struct

from lbr.capability.twins import DeviceTwin
from lbr.simulation.faults import LineFaults

Sense = Literal[-1, 1]


class RoboteqFaults(LineFaults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of the motor controller: those of a line, and more.

    `undervoltage`, `overheat`: the fault bit, power stage off. `no_watchdog`: it accepts the setting, and never acts.
    """

    undervoltage: bool = False
    overheat: bool = False
    no_watchdog: bool = False


class RoboteqRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The wiring of a `roboteq` device row: with a direction of -1, the wheel turns back for a positive command."""

    faults: RoboteqFaults = RoboteqFaults()
    left_channel: Literal[1, 2] = 1
    left_direction: Sense = -1
    right_direction: Sense = 1


TWIN = DeviceTwin(device="roboteq", row=RoboteqRow, entry="lbr.simulation.devices.roboteq.twin:RoboteqTwin")
