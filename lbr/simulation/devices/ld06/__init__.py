"""The emulated LD06 lidar: the settings of its device rows, its faults, and its twin."""

from msgspec import Struct

from lbr.capability.twins import DeviceTwin
from lbr.messages.units import Name
from lbr.simulation.faults import Faults, Probability


class Ld06Faults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of an LD06. `unplug`: cable out, lidar without power. `stalled`: its mirror stands. `dark`: no echo."""

    silent: bool = False
    stalled: bool = False
    dark: bool = False
    frozen: bool = False
    garbage: Probability = 0.0
    bit_flip: Probability = 0.0


class Ld06Row(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The row of `range_sensor` with the place of the lidar."""

    faults: Ld06Faults = Ld06Faults()
    sensor: Name = "lidar"


TWIN = DeviceTwin(device="ld06", row=Ld06Row, entry="lbr.simulation.devices.ld06.twin:Ld06Twin")
