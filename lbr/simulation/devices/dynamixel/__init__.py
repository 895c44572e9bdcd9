"""The emulated bus of AX-12A servos: what its device rows may set, what can go wrong with it, and which twin it has."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.twins import DeviceTwin
from lbr.simulation.bus_timing import BusTiming
from lbr.simulation.faults import Probability, ServoBusFaults


class DynamixelFaults(ServoBusFaults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a bus of AX-12A. Of answers, `stray`: a packet that was not asked for comes before; `pieces`: with a
    pause in it."""

    stray: Probability = 0.0
    pieces: Probability = 0.0


class DynamixelRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The servos on a `dynamixel` device row's bus, and how fast it is; `usb2ax` is a dongle's firmware, null: without
    one.

    `return_delay` is what the servos' registers hold at first, in 2 us; 250 as they leave the factory.
    `goal_switches_on`: a servo that gets a goal gets torque too, as some users say of theirs and the manual does not.
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
