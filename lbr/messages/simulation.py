"""Messages of the simulated world."""

from msgspec import Struct


class WorldBox(Struct, frozen=True, kw_only=True):
    """A box that stands on the floor, seen from above: centre and full size in metres, turned by `yaw_rad`."""

    name: str
    x_m: float
    y_m: float
    length_m: float
    width_m: float
    yaw_rad: float = 0.0


class WorldScene(Struct, frozen=True, kw_only=True):
    """What does not move, and the robot's outline."""

    walls: tuple[WorldBox, ...]
    robot_length_m: float
    robot_width_m: float


class WorldPose(Struct, frozen=True, kw_only=True):
    """The truth about the robot (REP 103: x ahead, y left, yaw anticlockwise) and its emulated motor outputs."""

    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float
    turn_rps: float
    left: float
    right: float
    touching: bool
    battery_v: float
    time_s: float
