"""Messages of the simulated world."""

from typing import Literal

from msgspec import Struct


class WorldBox(Struct, frozen=True, kw_only=True):
    """A thing on the floor, seen from above: centre and full size in metres, turned by `yaw_rad`.

    A cylinder is `length_m` thick. A thing that is not `solid` is only seen.
    """

    name: str
    x_m: float
    y_m: float
    length_m: float
    width_m: float
    yaw_rad: float = 0.0
    kind: Literal["box", "cylinder"] = "box"
    bottom_m: float = 0.0
    height_m: float = 1.5
    colour: str = ""
    solid: bool = True


class WorldDock(Struct, frozen=True, kw_only=True):
    """The charging dock: the middle of its face, which looks along `yaw_rad`, and its infrared beams.

    Each beam reaches from `overlap_rad` / 2 beyond the middle line to `spread_rad` on its own side.
    """

    x_m: float
    y_m: float
    yaw_rad: float
    depth_m: float
    width_m: float
    reach_m: float
    spread_rad: float
    overlap_rad: float


class WorldSensor(Struct, frozen=True, kw_only=True):
    """A sensor of one distance, seen from above: its place, direction and width."""

    name: str
    x_m: float
    y_m: float
    yaw_rad: float
    fov_rad: float


class WorldScene(Struct, frozen=True, kw_only=True):
    """The fixed things, the robot's outline, and its sensors of one distance."""

    walls: tuple[WorldBox, ...]
    robot_length_m: float
    robot_width_m: float
    dock: WorldDock | None = None
    sensors: tuple[WorldSensor, ...] = ()


class WorldPose(Struct, frozen=True, kw_only=True):
    """The truth about the robot (REP 103: x ahead, y left, yaw anticlockwise) and its emulated motors.

    `touching`: something else than the floor and its dock.
    """

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
    charging: bool = False


class HumanoidPose(Struct, frozen=True, kw_only=True):
    """The truth about a humanoid (REP 103): its trunk, its joints, and what it stands on.

    `upright`: it leans less than 45 degrees; `stands`: and does not sit. `held`: by a helper's hand or a stand.
    `on_floor`: the parts that touch the floor.
    """

    x_m: float
    y_m: float
    z_m: float
    roll_rad: float
    pitch_rad: float
    yaw_rad: float
    upright: bool
    held: bool
    on_floor: tuple[str, ...]
    joints: dict[str, float]
    supply_v: float
    time_s: float
    stands: bool = True

    @property
    def posture(self) -> str:
        """Return its posture, in one word for people."""
        if self.held or not self.upright:
            return "held" if self.held else "FALLEN"
        return "upright" if self.stands else "sitting"
