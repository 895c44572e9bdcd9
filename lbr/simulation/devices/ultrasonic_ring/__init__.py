"""The emulated ring of ultrasonic sensors: the settings of its device rows, its faults, and its twin."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.twins import DeviceTwin
from lbr.messages.units import Name
from lbr.simulation.faults import Faults, Probability

Board = Literal["arduino", "parallax"]
PinnedM = Annotated[float, Meta(ge=0.0, le=7.65, description="metres a sensor is made to see; null sees the world")]


class UltrasonicFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a ring of ultrasonic sensors, named by their rows of `range_sensor`.

    `half_lines`: a report ends early. `noise_cm`: standard deviation added. `missing`: absent sensors. `over_range`,
    `error`: they read 758 or 0. `range_*_m`: pins a sensor. `unplug`: cable out, board without power.
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
    """The board of an `ultrasonic_ring` device row."""

    faults: UltrasonicFaults = UltrasonicFaults()
    board: Board = "arduino"


TWIN = DeviceTwin(
    device="ultrasonic_ring", row=UltrasonicRow, entry="lbr.simulation.devices.ultrasonic_ring.twin:UltrasonicTwin"
)
