"""`beacon`: finds the charging dock by its infrared beams and backs onto its contacts, a manoeuvre at a time.

`manoeuvres` decides, without bus or clock; `kernel` grants leases; `pilot` moves the robot, by a lease of the drive
like any sender. The strategy is a table of the behaviours: the order of manoeuvres, and the number of tries.
"""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.kind import Command, Kind, Wire
from lbr.capability.word import Word
from lbr.messages.attitude import AttitudeState
from lbr.messages.battery import BatteryState
from lbr.messages.beacon import MANOEUVRES, BeaconState, SeekCommand
from lbr.messages.dock import DockSignal
from lbr.messages.drive import DriveCommand, DriveState, GoalResult, TurnCommand
from lbr.messages.leases import StopCommand
from lbr.messages.sensing import Ranges
from lbr.messages.units import TtlS


class BeaconSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `beacon`: the docked robot's heading and distances.

    `side` is the side of the first search for the dock, as the docked robot looks.
    """

    heading_deg: Annotated[
        float, Meta(ge=0.0, lt=360.0, description="of the docked robot; null: as at the first manoeuvre")
    ] = 0.0
    docked_back_cm: Annotated[
        float, Meta(ge=10.0, le=200.0, description="the distance to the wall behind, on the dock")
    ] = 36.0
    standoff_cm: Annotated[float, Meta(ge=80.0, le=400.0, description="where it looks for beams")] = 180.0
    side: Literal["left", "right"] = "left"
    reverse_steering: Annotated[
        Literal["rotation", "travel"], Meta(description="what the drive's setting of this name says")
    ] = "rotation"
    ttl_s: TtlS = 0.5


KIND = Kind(
    name="beacon",
    summary="finds the charging dock by its beams and backs onto its contacts, a manoeuvre at a time",
    family="operation",
    entry="lbr.robots.lbr.beacon.capability:Beacon",
    settings=BeaconSettings,
    inputs={
        "attitude": AttitudeState,
        "ranges": Ranges,
        "dock": DockSignal,
        "drive": DriveState,
        "results": GoalResult,
        "battery": BatteryState,
    },
    optional=("battery",),
    outputs={"state": BeaconState, "result": GoalResult},
    commands={
        "seek": Command(SeekCommand, leased=True, choices={"manoeuvre": lambda _known: MANOEUVRES}),
        "stop": StopCommand,
    },
    requests={"move": DriveCommand, "turn": TurnCommand, "halt": StopCommand},
    moves=True,
    wires={
        "attitude": Wire("attitude.state"),
        "ranges": Wire("readings"),
        "dock": Wire("signal"),
        "drive": Wire("drive.state", 4),
        "results": Wire("drive.result", 16),
        "battery": Wire("battery.state"),
        "move": Wire("drive.command"),
        "turn": Wire("drive.turn"),
        "halt": Wire("drive.stop"),
    },
    words=(
        Word(
            "/beacon/{manoeuvre}",
            "seek",
            "Do one manoeuvre by the dock's beams: align, search, follow, withdraw or roam; s ends it",
        ),
    ),
)
