"""The emulated bus of AX-12A servos: the settings of its device rows, its faults, and its twin."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.twins import DeviceTwin
from lbr.simulation.bus_timing import BusTiming
from lbr.simulation.faults import Probability, ServoBusFaults


class DynamixelFaults(ServoBusFaults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a bus of AX-12A. Of answers, `stray`: an unrequested packet before; `pieces`: with a pause."""

    stray: Probability = 0.0
    pieces: Probability = 0.0


class DynamixelRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The servos on a `dynamixel` device row's bus, and its speed; `usb2ax`: a dongle's firmware, null: none.

    `return_delay`: the servos' registers at first, in 2 us; 250 by the factory. `goal_switches_on`: a goal switches
    torque on, as some users report, unlike the manual.
    """

    faults: DynamixelFaults = DynamixelFaults()
    ids: Annotated[tuple[Annotated[int, Meta(ge=0, le=252)], ...], Meta(min_length=1, max_length=100)] = tuple(
        range(1, 19)
    )
    usb2ax: Literal[4, 5] | None = 5
    return_delay: Annotated[int, Meta(ge=0, le=254)] = 250
    goal_switches_on: bool = False
    timing: BusTiming = BusTiming()


TWIN = DeviceTwin(device="dynamixel", row=DynamixelRow, entry="lbr.simulation.devices.dynamixel.twin:DynamixelTwin")
