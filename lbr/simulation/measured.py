"""The measurements and acts of devices in the world."""

from typing import Literal

from msgspec import Struct

from lbr.messages.units import Vector

Beam = Literal["left", "right", "power"]

AT_REST = (0.0, 0.0, 0.0)


class ImuReading(Struct, frozen=True, kw_only=True):
    """The readings of an inertial unit at one instant, along its own axes, with its biases, its noise and the iron near
    it.

    `accel_mps2` is the specific force: at rest +9.81 along the axis that points up.
    """

    gyro_rps: Vector = AT_REST
    accel_mps2: Vector = (0.0, 0.0, 9.81)
    mag_ut: Vector = AT_REST
    temperature_c: float = 30.0


class MotorSensed(Struct, frozen=True, kw_only=True):
    """The measurements of one motor, forward positive; amperes of all its wheels, counts and speed of the first."""

    amps_a: float = 0.0
    battery_amps_a: float = 0.0
    counts: int = 0
    speed_rpm: float = 0.0


class Sensed(Struct, frozen=True, kw_only=True):
    """The measurements that the world gives its devices; pairs are the motors left and right, forward positive;
    `motors` has all.

    `scans_m` are distances along the rays of each scanner; null is nothing within reach. A world without wheels or
    ranges leaves theirs out. `imu` is as old as this; a device that is read more often receives each step. `charging`:
    both contacts of the dock touch, and `charging_a` flows into the battery. `beams` are the beams of the dock that the
    infrared receiver sees now.
    """

    battery_v: float
    amps_a: tuple[float, float] = (0.0, 0.0)
    battery_amps_a: tuple[float, float] = (0.0, 0.0)
    counts: tuple[int, int] = (0, 0)
    speeds_rpm: tuple[float, float] = (0.0, 0.0)
    motors: dict[str, MotorSensed] = {}
    ranges_m: dict[str, float | None] = {}
    scans_m: dict[str, tuple[float | None, ...]] = {}
    imu: ImuReading = ImuReading()
    charging: bool = False
    charging_a: float = 0.0
    beams: frozenset[Beam] = frozenset()


class ServoDrive(Struct, frozen=True, kw_only=True):
    """The motor of a servo by its registers, in the servo's own radians from the middle of its range.

    `torque` is a fraction of its maximum; 0: it is limp. It goes to its goal at `speed_rps` at most (null: as fast as
    it can). Within `margins_rad` of the goal its motor rests; beyond, its drive grows from `punch` by 1 over
    `slopes_rad`, up to `torque`. Both are for a goal that is further clockwise (negative) and further anticlockwise.
    `brake`: without torque its motor is shorted, so it resists turning like a driven one.
    """

    goal_rad: float = 0.0
    speed_rps: float | None = None
    torque: float = 0.0
    margins_rad: tuple[float, float] = (0.0051, 0.0051)
    slopes_rad: tuple[float, float] = (0.164, 0.164)
    punch: float = 0.031
    brake: bool = False


class ServoFelt(Struct, frozen=True, kw_only=True):
    """A servo in the world: its angle, its speed, and its motor's torque as a fraction of its maximum, signed."""

    position_rad: float
    speed_rps: float = 0.0
    load: float = 0.0
