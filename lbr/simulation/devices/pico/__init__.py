"""The emulated supply UPS PIco: the settings of its device rows, its faults, and its twin."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.twins import DeviceTwin
from lbr.simulation.faults import I2cFaults

SupplyV = Annotated[float, Meta(ge=0.0, le=99.99, description="volts")]


class PicoFaults(I2cFaults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a UPS PIco: those of its bus, its feed, and more.

    `hung`: its processor and counter stand still. `bad_bcd`: the external voltage is not a number. `mode_bit_7`: the
    mode's highest bit is set, without meaning. `external_v`, `battery_v`, `source`: fixed; null follows the world.
    """

    hung: bool = False
    bad_bcd: bool = False
    mode_bit_7: bool = False
    external_v: SupplyV | None = None
    battery_v: SupplyV | None = None
    source: Literal["external", "battery"] | None = None


class PicoRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The address of a `pico` device row's supply, and its own battery.

    `relay_on`: the relay's register while the motors have power, as at the beginning.
    """

    faults: PicoFaults = PicoFaults()
    i2c_address: Literal[0x69, 0x59] = 0x69
    relay_on: Literal[0, 1] = 1
    battery_v: Annotated[float, Meta(ge=0.0, le=5.0)] = 4.1
    temperature_c: Annotated[int, Meta(ge=0, le=99)] = 33


TWIN = DeviceTwin(device="pico", row=PicoRow, entry="lbr.simulation.devices.pico.twin:PicoTwin")
