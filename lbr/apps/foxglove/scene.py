"""A body in space for Foxglove: its shapes on frames of their own, and the places of those frames. Pure."""

from collections.abc import Iterator, Mapping, Sequence

from lbr.apps.bodies import turning
from lbr.apps.bodies.parts import Link, RobotModel, Shape
from lbr.apps.bodies.turning import Place, Turn
from lbr.messages.attitude import AttitudeState
from lbr.messages.odometry import OdometryState

WORLD, BASE = "odom", "base_link"
_EMPTY: tuple[str, ...] = (
    "metadata", "arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models",
)  # fmt: skip


def stamp(at_ns: int) -> dict[str, int]:
    """Return a time in the form of Foxglove's JSON messages."""
    return {"sec": at_ns // 1_000_000_000, "nsec": at_ns % 1_000_000_000}


def scene(model: RobotModel, at_ns: int) -> dict[str, object]:
    """Return a SceneUpdate that draws a body, each link on the frame of its name; it stays until the next one."""
    drawn = [_entity(link, at_ns) for link in model.links if link.shapes]
    return {"deletions": [{"timestamp": stamp(at_ns), "type": 1, "id": ""}], "entities": drawn}


def transforms(
    model: RobotModel,
    angles: Mapping[str, float],
    odometry: OdometryState | None,
    attitude: AttitudeState | None,
    at_ns: int,
) -> dict[str, object]:
    """Return FrameTransforms: the base in the world, by odometry or else attitude, and each link in its parent."""
    made = [_transform(WORLD, BASE, base(odometry, attitude), at_ns)]
    known = {link.name for link in model.links}
    for link in model.links:
        parent = frame(link.parent) if link.parent in known else BASE
        made.append(_transform(parent, frame(link.name), placed(link, angles.get(link.joint, 0.0), model), at_ns))
    return {"transforms": made}


def frame(link: str) -> str:
    """Return the frame of a link."""
    return f"{BASE}/{link}"


def base(odometry: OdometryState | None, attitude: AttitudeState | None) -> Place:
    """Return the known place of the base."""
    if odometry is not None and odometry.x_m is not None and odometry.y_m is not None:
        return Place((odometry.x_m, odometry.y_m, 0.0), turning.about((0.0, 0.0, 1.0), odometry.yaw_rad or 0.0))
    if attitude is not None and attitude.valid and attitude.orientation is not None:
        w, x, y, z = attitude.orientation
        return Place(turn=(w, x, y, z))
    return Place()


def placed(link: Link, value: float, model: RobotModel) -> Place:
    """Return the place of a link in its parent, with its joint at a value."""
    at = Place(link.origin_xyz, turning.by_euler(link.origin_rpy, "XYZ"))
    if not link.joint or not value:
        return at
    joint = model.joints.get(link.joint)
    if joint is not None and joint.kind == "slide":
        x, y, z = link.axis
        return at.then(Place((x * value, y * value, z * value)))
    return at.then(Place(turn=turning.about(link.axis, value)))


def pose(at: Place) -> dict[str, object]:
    """Return a Pose."""
    return {"position": _xyz(at.xyz), "orientation": _turn(at.turn)}


def entity(name: str, on: str, at_ns: int, **shapes: object) -> dict[str, object]:
    """Return a SceneEntity that moves with a frame."""
    return {
        "timestamp": stamp(at_ns),
        "frame_id": on,
        "id": name,
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": True,
        **{kind: [] for kind in _EMPTY},
        **shapes,
    }


def colour(rgba: Sequence[float]) -> dict[str, float]:
    """Return a Color."""
    return dict(zip("rgba", rgba, strict=True))


def _entity(link: Link, at_ns: int) -> dict[str, object]:
    shapes: dict[str, list[object]] = {}
    for shape in link.shapes:
        for kind, primitive in _primitives(shape):
            shapes.setdefault(kind, []).append(primitive)
    return entity(link.name, frame(link.name), at_ns, **shapes)


def _primitives(shape: Shape) -> Iterator[tuple[str, dict[str, object]]]:
    at = Place(shape.xyz, turning.by_euler(shape.rpy, "XYZ"))
    match shape.kind:
        case "box":
            yield "cubes", _solid(at, shape.size, shape)
        case "sphere":
            yield "spheres", _solid(at, (2 * shape.size[0],) * 3, shape)
        case "ellipsoid":
            yield "spheres", _solid(at, [2 * radius for radius in shape.size], shape)
        case "cylinder" | "capsule":
            radius, length = shape.size[:2]
            size = (2 * radius, 2 * radius, length)
            yield "cylinders", _solid(at, size, shape) | {"bottom_scale": 1.0, "top_scale": 1.0}
            for end in (-length / 2, length / 2) if shape.kind == "capsule" else ():
                yield "spheres", _solid(at.then(Place((0.0, 0.0, end))), (2 * radius,) * 3, shape)


def _solid(at: Place, size: Sequence[float], shape: Shape) -> dict[str, object]:
    return {"pose": pose(at), "size": _xyz(size), "color": colour(shape.rgba)}


def _transform(parent: str, child: str, at: Place, at_ns: int) -> dict[str, object]:
    return {
        "timestamp": stamp(at_ns),
        "parent_frame_id": parent,
        "child_frame_id": child,
        "translation": _xyz(at.xyz),
        "rotation": _turn(at.turn),
    }


def _xyz(values: Sequence[float]) -> dict[str, float]:
    return dict(zip("xyz", values, strict=True))


def _turn(turn: Turn) -> dict[str, float]:
    w, x, y, z = turn
    return {"x": x, "y": y, "z": z, "w": w}
