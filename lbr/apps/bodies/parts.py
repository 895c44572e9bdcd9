"""The parts of a body."""

from typing import Literal

from msgspec import Struct

Xyz = tuple[float, float, float]
Rgba = tuple[float, float, float, float]
ShapeKind = Literal["box", "cylinder", "sphere", "capsule", "ellipsoid"]
JointKind = Literal["hinge", "slide", "wheel"]
ORIGIN: Xyz = (0.0, 0.0, 0.0)
GREY: Rgba = (0.5, 0.5, 0.5, 1.0)


class Shape(Struct, frozen=True, kw_only=True):
    """A solid on a link, in the link's own axes.

    `size` depends on the kind. Box: three edges. Ellipsoid: three radii. Sphere: the radius. Cylinder: the radius and
    the length along z. Capsule: the same, without its round ends.
    """

    kind: ShapeKind
    size: tuple[float, ...]
    xyz: Xyz = ORIGIN
    rpy: Xyz = ORIGIN
    rgba: Rgba = GREY


class Link(Struct, frozen=True, kw_only=True):
    """A rigid part. With its joint at 0 its axes are at `origin_xyz` in its parent's, turned by `origin_rpy`.

    Roll, pitch and yaw are about the parent's x, y and z, one after the other. A hinge turns the part about `axis`,
    which is in its own axes, by the joint's angle; a slide moves it along. Parents come before their children. A root
    has no parent, and the axes of the floor below the robot.
    """

    name: str
    parent: str = ""
    joint: str = ""
    axis: Xyz = (0.0, 0.0, 1.0)
    origin_xyz: Xyz = ORIGIN
    origin_rpy: Xyz = ORIGIN
    shapes: tuple[Shape, ...] = ()


class Sensor(Struct, frozen=True, kw_only=True):
    """A sensor on `link` that looks along its own x axis, or measures along its axes."""

    name: str
    kind: str
    link: str
    xyz: Xyz = ORIGIN
    rpy: Xyz = ORIGIN
    fov_rad: float | None = None
    max_m: float | None = None


class Body(Struct, frozen=True, kw_only=True):
    """A whole body; `joints` are the kinds of the links' joints, `left_out` names the parts that cannot be drawn."""

    links: tuple[Link, ...] = ()
    joints: dict[str, JointKind] = {}
    sensors: tuple[Sensor, ...] = ()
    left_out: tuple[str, ...] = ()


class JointRange(Struct, frozen=True, kw_only=True):
    """The limits of a joint from its row; `drawn` is true if a link has it."""

    lower: float | None = None
    upper: float | None = None
    kind: JointKind = "hinge"
    side: Literal["left", "right", "centre"] = "centre"
    speed_rps: float | None = None
    drawn: bool = True


class RobotModel(Struct, frozen=True, kw_only=True):
    """A robot's body with the limits of its rows; without links, `reason` is why."""

    robot: str
    links: tuple[Link, ...] = ()
    joints: dict[str, JointRange] = {}
    sensors: tuple[Sensor, ...] = ()
    left_out: tuple[str, ...] = ()
    reason: str = ""
