"""The emulated bus of AX-12A servos: what its device rows may set, what can go wrong with it, and which twin it has."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.twins import DeviceTwin
from lbr.simulation.bus_timing import BusTiming
from lbr.simulation.faults import Faults, Probability, ServoIds


class DynamixelFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a servo bus; lists are of servos' ids. `unplug`: the adapter is out, the servos go on.

    `silent`: they obey but say nothing. `other_baud`: they hear nothing. `unpowered`: without supply, and as after
    switching on when that ends; `brown_out`: all of them. `overload`, `hot`: what they report, and switch off for.
    `wrong_model`: they are no AX-12A. `duplicate`: another servo answers to the same id. `babbling`: something on the
    line talks all the time. `echo`: the adapter hands back what it is given.
    Of answers, `drop`: none comes; `bit_flip`: a bit is wrong; `garbage`, `stray`: noise, or a packet that was not asked for,
    comes before; `half`: it ends early; `pieces`: with a pause in it; `late`: 12 ms later.
    """

    silent: ServoIds = ()
    other_baud: ServoIds = ()
    unpowered: ServoIds = ()
    overload: ServoIds = ()
    hot: ServoIds = ()
    wrong_model: ServoIds = ()
    duplicate: ServoIds = ()
    brown_out: bool = False
    babbling: bool = False
    echo: bool = False
    drop: Probability = 0.0
    bit_flip: Probability = 0.0
    garbage: Probability = 0.0
    stray: Probability = 0.0
    half: Probability = 0.0
    pieces: Probability = 0.0
    late: Probability = 0.0


class DynamixelRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What hangs on a `dynamixel` device row's bus, and how fast it is; `usb2ax` is a dongle's firmware, null: none.

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
