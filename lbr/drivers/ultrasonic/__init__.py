"""Ring of ultrasonic range sensors behind a microcontroller on a serial line: its kind and its settings."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.kind import Kind, OnDevice, Wire
from lbr.messages.drive import DriveState
from lbr.messages.sensing import RING, Ranges
from lbr.messages.units import Name

Board = Literal["arduino", "parallax"]
SENSORS = RING
"""The sensors that every board reports."""


class UltrasonicSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `ultrasonic_ring`.

    The board reports five sensors, and others by their rows of `range_sensor`. An MB1220 measures from 20 cm by its
    makers; here 17 to 19 cm are real: the dock is that near.
    """

    device: Name
    board: Board = "arduino"
    absent: tuple[Name, ...] = ("bottom",)
    min_cm: Annotated[int, Meta(ge=1, le=100, description="below this the sensor cannot measure")] = 17
    over_range_cm: Annotated[int, Meta(ge=100, le=768, description="from here on nothing is within reach")] = 758
    max_cm: Annotated[int, Meta(ge=769, le=2000, description="above this the number is a fault")] = 800
    still_cm: Annotated[int, Meta(ge=0, le=50, description="a distance within this of what it was is unchanged")] = 5
    timeout_s: Annotated[float, Meta(ge=0.1, le=5.0, description="silence that counts as a fault")] = 0.5
    start_timeout_s: Annotated[float, Meta(ge=0.1, le=10.0, description="the board's start-up after opening")] = 3.0
    baud: Literal[9600, 57600, 115200] = 115200


KIND = Kind(
    name="ultrasonic_ring",
    summary="ring of ultrasonic range sensors on an Arduino or Parallax board",
    family="driver",
    entry="lbr.drivers.ultrasonic.capability:UltrasonicRing",
    settings=UltrasonicSettings,
    inputs={"drive": DriveState},
    optional=("drive",),
    wires={"drive": Wire("drive.state")},
    outputs={"readings": Ranges},
    device=OnDevice("ultrasonic_ring", line="serial", recognised="lbr.drivers.ultrasonic.recognition:HANDSHAKES"),
)
