"""Settings of a `world` row; the defaults are a furnished room with the lbr6 robot and its dock in it."""

from math import cos, radians, sin
from typing import Annotated

from msgspec import Meta, Struct, field

from lbr.messages.units import Vector
from lbr.simulation.balls import Ball
from lbr.simulation.room import ROOM, BoxSettings, Height, Length, Place

__all__ = [
    "Battery",
    "Body",
    "BoxSettings",
    "Compass",
    "Dock",
    "Imu",
    "Mount",
    "StartPose",
    "Ultrasonic",
    "WorldSettings",
]

Degrees = Annotated[float, Meta(ge=-360.0, le=360.0)]
Spread = Annotated[float, Meta(ge=0.0, description="standard deviation")]


class StartPose(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The robot's start: x ahead, y left, yaw anticlockwise."""

    x_m: Place = 0.0
    y_m: Place = 0.0
    yaw_rad: float = 0.0


class Body(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The robot's body and drive; `max_speed_mps`: at full power."""

    length_m: Annotated[float, Meta(ge=0.2, le=3.0)] = 0.43
    width_m: Annotated[float, Meta(ge=0.15, le=3.0)] = 0.30
    height_m: Annotated[float, Meta(ge=0.3, le=3.0)] = 1.42
    mass_kg: Annotated[float, Meta(ge=1.0, le=500.0)] = 16.0
    wheel_diameter_m: Annotated[float, Meta(ge=0.05, le=1.0)] = 0.1778
    counts_per_turn: Annotated[int, Meta(ge=1)] = 130
    max_speed_mps: Annotated[float, Meta(gt=0.0, le=5.0)] = 1.0
    acceleration_mps2: Annotated[float, Meta(gt=0.0, le=10.0)] = 1.2
    deceleration_mps2: Annotated[float, Meta(gt=0.0, le=10.0)] = 2.5


class Battery(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A 12 V AGM: volts at rest when full, inner resistance, capacity, first charge, idle current.

    On the dock the voltage rises to `charged_v` within a few times `charging_s`, and falls as slowly.
    """

    open_circuit_v: Annotated[float, Meta(ge=6.0, le=60.0)] = 12.7
    internal_ohm: Annotated[float, Meta(ge=0.0, le=5.0)] = 0.05
    capacity_ah: Annotated[float, Meta(gt=0.0)] = 35.0
    charge: Annotated[float, Meta(ge=0.0, le=1.0)] = 1.0
    idle_a: Annotated[float, Meta(ge=0.0, le=100.0)] = 1.5
    charged_v: Annotated[float, Meta(ge=6.0, le=80.0)] = 13.8
    charging_s: Annotated[float, Meta(gt=0.0)] = 60.0


class Mount(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The place of a part on the robot, z above the floor, turned by yaw, then pitch, then roll (REP 103)."""

    x_m: Place = 0.0
    y_m: Place = 0.0
    z_m: Height = 0.2
    roll_deg: Degrees = 0.0
    pitch_deg: Annotated[float, Meta(ge=-360.0, le=360.0, description="downwards positive")] = 0.0
    yaw_deg: Degrees = 0.0


class Imu(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The inertial unit: its mount, its errors, and the iron that turns with it.

    The compass reads `soft_iron` (rows of a matrix) times the field, plus `hard_iron_ut`, along the unit's axes.
    """

    mount: Mount = Mount()
    gyro_bias_rps: Vector = (0.011, -0.007, 0.009)
    gyro_noise_rps: Spread = 0.0015
    accel_bias_mps2: Vector = (0.08, -0.05, 0.1)
    accel_noise_mps2: Spread = 0.04
    hard_iron_ut: Vector = (6.0, -4.0, 3.0)
    soft_iron: tuple[Vector, Vector, Vector] = ((1.04, 0.03, 0.0), (0.03, 0.97, 0.0), (0.0, 0.0, 1.0))
    mag_noise_ut: Spread = 0.4
    temperature_c: Annotated[float, Meta(ge=-40.0, le=125.0)] = 32.0


class Compass(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The earth's magnetic field. `north_deg`: magnetic north, anticlockwise from the world's x axis.

    By default x points north: an unturned robot heads 0 degrees, towards the north wall.
    """

    field_ut: Annotated[float, Meta(ge=0.0, le=100.0)] = 48.0
    inclination_deg: Annotated[float, Meta(ge=-90.0, le=90.0, description="how steeply the field points down")] = 65.0
    north_deg: Degrees = 0.0

    @property
    def vector_ut(self) -> Vector:
        """Return the field in the world's axes; z is up."""
        down, north = radians(self.inclination_deg), radians(self.north_deg)
        level = self.field_ut * cos(down)
        return level * cos(north), level * sin(north), -self.field_ut * sin(down)


class Ultrasonic(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Sensors of a single distance: noise and lost echoes. `height_m` null: that of their rows.

    Noise is `noise_m`, and `noise_per_m` for each metre. `dropout`: the share of readings without an echo. A surface
    hit more than `grazing_deg` off its normal gives no echo; 90: all do.
    """

    height_m: Height | None = None
    noise_m: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.008
    noise_per_m: Annotated[float, Meta(ge=0.0, le=0.5)] = 0.0
    dropout: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.0
    grazing_deg: Annotated[float, Meta(gt=0.0, le=90.0)] = 90.0


class Dock(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The charging dock: the middle of its face, whose normal points along `yaw_rad`, and its beams.

    Ultrasonic sensors look over it from nearby. The robot backs against it and charges while both contacts,
    `contacts_m` apart, touch within `give_m`, and within `plate_m` to each side. A beam reaches from `overlap_deg` / 2
    beyond the middle line to `spread_deg`, the left one to the dock's left (y). The receiver sees within `receiver_deg`
    around straight back.
    """

    x_m: Place = -1.14
    y_m: Place = 1.2
    yaw_rad: float = 0.0
    depth_m: Length = 0.36
    width_m: Length = 0.30
    height_m: Length = 0.16
    contacts_m: Length = 0.10
    give_m: Length = 0.02
    plate_m: Length = 0.03
    current_a: Annotated[float, Meta(ge=0.0, le=50.0)] = 3.0
    reach_m: Length = 3.0
    spread_deg: Annotated[float, Meta(gt=0.0, le=90.0)] = 25.0
    overlap_deg: Annotated[float, Meta(ge=0.0, le=90.0)] = 6.0
    receiver_deg: Annotated[float, Meta(gt=0.0, le=360.0)] = 120.0


CAMERAS = {
    "front": Mount(x_m=0.06, z_m=1.25, pitch_deg=12.0),
    "rear": Mount(x_m=-0.06, z_m=1.25, pitch_deg=12.0, yaw_deg=180.0),
}
"""On the mast, looking a little down."""
BALLS = {"ball": Ball(x_m=1.5, z_m=1.0, radius_m=0.07, gone=True)}
"""At the height at which a person holds it before the camera, once it is placed."""


class WorldSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The simulated world.

    `seed` fixes all noise. `walls`: all fixed things, including furniture. `dock` null: none. `cameras`: their places,
    by name; `balls`: their targets, without echo or body. `trace`: a file that gets each change of the motor outputs.
    """

    seed: int = 1
    walls: tuple[BoxSettings, ...] = ROOM
    dock: Dock | None = Dock()
    start: StartPose = StartPose()
    body: Body = Body()
    battery: Battery = Battery()
    imu: Imu = Imu()
    compass: Compass = Compass()
    ultrasonic: Ultrasonic = Ultrasonic()
    cameras: dict[str, Mount] = field(default_factory=lambda: dict(CAMERAS))
    balls: Annotated[dict[str, Ball], Meta(max_length=8)] = field(default_factory=lambda: dict(BALLS))
    camera_fov_deg: Annotated[float, Meta(gt=1.0, lt=170.0, description="from top to bottom")] = 45.0
    pose_hz: Annotated[float, Meta(ge=1.0, le=100.0)] = 20.0
    scene_every_s: Annotated[float, Meta(gt=0.0, le=60.0)] = 2.0
    trace: str = ""
