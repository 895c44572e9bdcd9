"""Battery: charge and charging, from the motor controller's measurements."""

from itertools import pairwise
from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.kind import Kind
from lbr.messages.battery import BatteryState
from lbr.messages.motors import MotorsState
from lbr.messages.speech import SayCommand

Volts = Annotated[float, Meta(gt=0.0, le=100.0)]
Seconds = Annotated[float, Meta(ge=0.0, le=600.0)]

AGM_12V: tuple[tuple[float, float], ...] = (
    (10.5, 0.0),
    (11.3, 0.1),
    (11.5, 0.2),
    (11.7, 0.3),
    (11.9, 0.4),
    (12.0, 0.5),
    (12.2, 0.6),
    (12.4, 0.7),
    (12.5, 0.8),
    (12.6, 0.9),
    (12.7, 1.0),
)
"""Volts at rest, and charge, of a lead-acid battery of six cells."""


class BatterySettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `battery`; the defaults are a 12 V AGM battery of 35 Ah.

    `table`: volts at rest and charge, both ascending. The volts at rest are the measured ones plus the voltage drop
    over `internal_ohm` (battery and cables). `idle_a` is drawn beside the motors. It charges once these volts are above
    `charging_v` for `charging_after_s`, until they are below `discharging_v` for `discharging_after_s` or it drives.
    Afterwards only a rise by `charging_rise_v` means a charger.
    """

    table: Annotated[tuple[tuple[Volts, Annotated[float, Meta(ge=0.0, le=1.0)]], ...], Meta(min_length=2)] = AGM_12V
    internal_ohm: Annotated[float, Meta(ge=0.0, le=2.0)] = 0.05
    idle_a: Annotated[float, Meta(ge=0.0, le=50.0)] = 1.5
    filter_s: Annotated[float, Meta(ge=0.0, le=60.0, description="time constant of what is shown")] = 2.0
    max_age_s: Annotated[float, Meta(gt=0.0, le=60.0, description="an older voltage does not count")] = 2.0
    charging_v: Volts = 12.9
    charging_after_s: Seconds = 2.0
    charging_rise_v: Annotated[float, Meta(ge=0.0, le=5.0)] = 0.15
    discharging_v: Volts = 12.75
    discharging_after_s: Seconds = 5.0
    critical_v: Volts = 10.6
    critical_margin_v: Annotated[float, Meta(ge=0.0, le=5.0)] = 0.3
    low_charge: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.2
    low_margin: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.05
    repeat_s: Annotated[float, Meta(ge=1.0, le=86400.0, description="between two warnings of one kind")] = 60.0

    def __post_init__(self) -> None:
        """Refuse settings that contradict each other."""
        for (volts, charge), (more_volts, more_charge) in pairwise(self.table):
            if not (more_volts > volts and more_charge >= charge):
                raise ValueError(f"table: after {volts:g} V and {charge:g} both must grow")
        if not self.discharging_v <= self.charging_v:
            raise ValueError("discharging_v: must not be above charging_v")


def charge_at(rest_voltage_v: float, table: tuple[tuple[float, float], ...]) -> float:
    """Return the charge for a voltage at rest, interpolated in the table."""
    if not rest_voltage_v > table[0][0]:  # this way round, NaN is empty
        return table[0][1]
    for (volts, charge), (more_volts, more_charge) in pairwise(table):
        if rest_voltage_v <= more_volts:
            return charge + (more_charge - charge) * (rest_voltage_v - volts) / (more_volts - volts)
    return table[-1][1]


KIND = Kind(
    name="battery",
    summary="charge, charging and low-battery warnings of a lead-acid battery",
    family="operation",
    entry="lbr.operations.battery.capability:Battery",
    settings=BatterySettings,
    inputs={"motors": MotorsState},
    outputs={"state": BatteryState},
    requests={"say": SayCommand},
)
