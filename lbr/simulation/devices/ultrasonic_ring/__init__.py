"""The emulated ring of ultrasonic sensors: what its device rows may set, what can go wrong with it, and which twin it
has."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.twins import DeviceTwin
from lbr.messages.units import Name
from lbr.simulation.faults import Faults, Probability

Board = Literal["arduino", "parallax"]
PinnedM = Annotated[float, Meta(ge=0.0, le=7.65, description="metres a sensor is made to see; null sees the world")]


class UltrasonicFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a ring of ultrasonic sensors, which are told by the names of their rows of `range_sensor`.

    `frozen`: the same numbers for ever. `garbage`, `half_lines`: a report has noise before it, or ends early without
    its line end. `noise_cm`: standard deviation added. `missing`: sensors that are not there. `over_range`, `error`:
    sensors that read 758 or 0. `range_*_m` pins a sensor to a distance. `unplug`: cable out, board without power.
    """

    silent: bool = False
    frozen: bool = False
    garbage: Probability = 0.0
    half_lines: Probability = 0.0
    noise_cm: Annotated[float, Meta(ge=0.0, le=200.0)] = 0.0
    missing: tuple[Name, ...] = ()
    over_range: tuple[Name, ...] = ()
    error: tuple[Name, ...] = ()
    range_forward_m: PinnedM | None = None
    range_left_m: PinnedM | None = None
    range_right_m: PinnedM | None = None
    range_back_m: PinnedM | None = None


class UltrasonicRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Which board an `ultrasonic_ring` device row means."""

    faults: UltrasonicFaults = UltrasonicFaults()
    board: Board = "arduino"


TWIN = DeviceTwin(
    device="ultrasonic_ring", row=UltrasonicRow, entry="lbr.simulation.devices.ultrasonic_ring.twin:UltrasonicTwin"
)
