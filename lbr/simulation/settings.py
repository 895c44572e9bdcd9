"""What a `world` row may set; the defaults are a furnished room with the lbr6 robot in it."""

from typing import Annotated

from msgspec import Meta, Struct

Length = Annotated[float, Meta(gt=0.0, le=1000.0, description="metres")]
Place = Annotated[float, Meta(ge=-1000.0, le=1000.0, description="metres")]


class BoxSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A box that stands on the floor: its centre, its full size, and how far it is turned anticlockwise."""

    name: str
    x_m: Place
    y_m: Place
    length_m: Length
    width_m: Length
    height_m: Length = 1.5
    yaw_rad: float = 0.0


class StartPose(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the robot stands at the beginning: x ahead, y left, yaw anticlockwise."""

    x_m: Place = 0.0
    y_m: Place = 0.0
    yaw_rad: float = 0.0


class Body(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The robot's body and drive; `max_speed_mps` is its speed at full power."""

    length_m: Annotated[float, Meta(ge=0.2, le=3.0)] = 0.43
    width_m: Annotated[float, Meta(ge=0.15, le=3.0)] = 0.30
    height_m: Annotated[float, Meta(ge=0.2, le=3.0)] = 1.42
    mass_kg: Annotated[float, Meta(ge=1.0, le=500.0)] = 16.0
    wheel_diameter_m: Annotated[float, Meta(ge=0.05, le=1.0)] = 0.1778
    counts_per_turn: Annotated[int, Meta(ge=1)] = 130
    max_speed_mps: Annotated[float, Meta(gt=0.0, le=5.0)] = 1.0
    acceleration_mps2: Annotated[float, Meta(gt=0.0, le=10.0)] = 1.2
    deceleration_mps2: Annotated[float, Meta(gt=0.0, le=10.0)] = 2.5


class Battery(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A 12 V AGM: volts at rest when full, inner resistance, capacity, charge at the start, and what idles."""

    open_circuit_v: Annotated[float, Meta(ge=6.0, le=60.0)] = 12.7
    internal_ohm: Annotated[float, Meta(ge=0.0, le=5.0)] = 0.05
    capacity_ah: Annotated[float, Meta(gt=0.0)] = 35.0
    charge: Annotated[float, Meta(ge=0.0, le=1.0)] = 1.0
    idle_a: Annotated[float, Meta(ge=0.0, le=100.0)] = 1.5


ROOM = (
    BoxSettings(name="north wall", x_m=4.55, y_m=0.0, length_m=0.1, width_m=5.2, height_m=2.4),
    BoxSettings(name="south wall", x_m=-1.55, y_m=0.0, length_m=0.1, width_m=5.2, height_m=2.4),
    BoxSettings(name="west wall", x_m=1.5, y_m=2.55, length_m=6.2, width_m=0.1, height_m=2.4),
    BoxSettings(name="east wall", x_m=1.5, y_m=-2.55, length_m=6.2, width_m=0.1, height_m=2.4),
    BoxSettings(name="cupboard", x_m=3.9, y_m=-2.2, length_m=1.0, width_m=0.5),
    BoxSettings(name="table", x_m=2.4, y_m=1.6, length_m=0.9, width_m=0.6, height_m=0.75),
    BoxSettings(name="crate", x_m=1.1, y_m=-1.7, length_m=0.4, width_m=0.4, height_m=0.5, yaw_rad=0.5),
    BoxSettings(name="shelf", x_m=-0.9, y_m=2.3, length_m=0.8, width_m=0.3),
)
"""A room of 6 by 5 m; the robot starts at the origin with 4.5 m free ahead of it."""


class WorldSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The simulated world: what stands in it, where the robot starts, and how often it tells.

    `seed` fixes all noise. `trace` names a file that gets each change of the motor controller's outputs.
    """

    seed: int = 1
    walls: tuple[BoxSettings, ...] = ROOM
    start: StartPose = StartPose()
    body: Body = Body()
    battery: Battery = Battery()
    range_noise_m: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.008
    pose_hz: Annotated[float, Meta(ge=1.0, le=100.0)] = 20.0
    scene_every_s: Annotated[float, Meta(gt=0.0, le=60.0)] = 2.0
    trace: str = ""
