"""The robot's messages in Foxglove's own schemas: pictures, poses, scans, rays of range sensors, events. Pure."""

import base64
from collections.abc import Sequence
from math import cos, isfinite, sin

from lbr.apps.foxglove.scene import BASE, WORLD, base, colour, entity, pose, stamp
from lbr.bus import pictures
from lbr.messages.odometry import OdometryState
from lbr.messages.sensing import Ranges, RangeSensor, Scan
from lbr.messages.system import Event

_TIME = {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}}
_NUMBER, _TEXT = {"type": "number"}, {"type": "string"}
_XYZ = {"type": "object", "properties": dict.fromkeys("xyz", _NUMBER)}
_TURN = {"type": "object", "properties": dict.fromkeys("xyzw", _NUMBER)}
_POSE = {"type": "object", "properties": {"position": _XYZ, "orientation": _TURN}}
_MANY = {"type": "array", "items": {"type": "object"}}
_NUMBERS = {"type": "array", "items": _NUMBER}
_DURATION = _TIME
_FIELDS: dict[str, dict[str, object]] = {
    "CompressedImage": {
        "timestamp": _TIME, "frame_id": _TEXT, "data": {"type": "string", "contentEncoding": "base64"}, "format": _TEXT,
    },
    "Log": {
        "timestamp": _TIME, "level": {"type": "integer"}, "message": _TEXT, "name": _TEXT, "file": _TEXT,
        "line": {"type": "integer"},
    },
    "PoseInFrame": {"timestamp": _TIME, "frame_id": _TEXT, "pose": _POSE},
    "LaserScan": {
        "timestamp": _TIME, "frame_id": _TEXT, "pose": _POSE, "start_angle": _NUMBER, "end_angle": _NUMBER,
        "ranges": _NUMBERS, "intensities": _NUMBERS,
    },
    "FrameTransforms": {
        "transforms": {
            "type": "array",
            "items": {
                "type": "object",
                "properties": {
                    "timestamp": _TIME, "parent_frame_id": _TEXT, "child_frame_id": _TEXT, "translation": _XYZ,
                    "rotation": _TURN,
                },
            },
        },
    },
    "SceneUpdate": {
        "deletions": {
            "type": "array",
            "items": {"type": "object", "properties": {"timestamp": _TIME, "type": {"type": "integer"}, "id": _TEXT}},
        },
        "entities": {
            "type": "array",
            "items": {
                "type": "object",
                "properties": {
                    "timestamp": _TIME, "frame_id": _TEXT, "id": _TEXT, "lifetime": _DURATION,
                    "frame_locked": {"type": "boolean"}, "metadata": _MANY, "arrows": _MANY, "cubes": _MANY,
                    "spheres": _MANY, "cylinders": _MANY, "lines": _MANY, "triangles": _MANY, "texts": _MANY,
                    "models": _MANY,
                },
            },
        },
    },
}  # fmt: skip
SCHEMAS: dict[str, dict[str, object]] = {
    f"foxglove.{name}": {"title": f"foxglove.{name}", "type": "object", "properties": fields}
    for name, fields in _FIELDS.items()
}
"""The part of Foxglove's JSON Schemas that our messages use."""
_LEVELS = {"info": 2, "warning": 3, "error": 4}
_NEAR, _FREE = (0.95, 0.35, 0.1, 0.9), (0.2, 0.6, 0.95, 0.5)
_NEAR_M = 0.5


def image(data: bytes, camera: str, at_ns: int) -> dict[str, object]:
    """Return a CompressedImage."""
    return {
        "timestamp": stamp(at_ns),
        "frame_id": camera,
        "format": "jpeg" if pictures.is_whole(data) else "broken",
        "data": base64.b64encode(data).decode(),
    }


def log(event: Event, at_ns: int) -> dict[str, object]:
    """Return a Log."""
    code = f" [{event.code}]" if event.code else ""
    return {
        "timestamp": stamp(event.wall_ns if 0 < event.wall_ns < 2**62 else at_ns),
        "level": _LEVELS[event.level],
        "message": f"{event.text}{code}",
        "name": event.subject,
        "file": event.kind,
        "line": 0,
    }


def position(odometry: OdometryState, at_ns: int) -> dict[str, object]:
    """Return a PoseInFrame."""
    return {"timestamp": stamp(at_ns), "frame_id": WORLD, "pose": pose(base(odometry, None))}


def laser(scan: Scan, sensor: RangeSensor | None, at_ns: int) -> dict[str, object]:
    """Return a LaserScan; rays without a measurement, or too near, are 0, which draws nothing."""
    metres = scan.metres()
    return {
        "timestamp": stamp(at_ns),
        "frame_id": BASE,
        "pose": _looking(sensor),
        "start_angle": scan.angle_min_rad,
        "end_angle": scan.angle_max_rad,
        "ranges": [value if isfinite(value) else 0.0 for value in metres],
        "intensities": [],
    }


def rays(ranges: Ranges, sensors: Sequence[RangeSensor], at_ns: int) -> dict[str, object]:
    """Return a SceneUpdate with a line for each sensor that measures something; red if it is near."""
    drawn = []
    for sensor in sensors:
        metres = ranges.metres(sensor.name) if sensor.rays == 1 else None
        if metres is None or not isfinite(metres):
            continue
        ahead = metres * cos(sensor.pitch_rad)
        begin = (sensor.x_m, sensor.y_m, sensor.z_m)
        end = (
            begin[0] + ahead * cos(sensor.yaw_rad),
            begin[1] + ahead * sin(sensor.yaw_rad),
            begin[2] - metres * sin(sensor.pitch_rad),
        )
        line = {
            "type": 0,
            "pose": {
                "position": {"x": 0.0, "y": 0.0, "z": 0.0},
                "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
            },
            "thickness": 0.01,
            "scale_invariant": False,
            "points": [dict(zip("xyz", point, strict=True)) for point in (begin, end)],
            "color": colour(_NEAR if metres < _NEAR_M else _FREE),
            "colors": [],
            "indices": [],
        }
        drawn.append(entity(f"range {sensor.name}", BASE, at_ns, lines=[line]))
    silent = [one.name for one in sensors if f"range {one.name}" not in {entry["id"] for entry in drawn}]
    gone = [{"timestamp": stamp(at_ns), "type": 0, "id": f"range {name}"} for name in silent]
    return {"deletions": gone, "entities": drawn}


def _looking(sensor: RangeSensor | None) -> dict[str, object]:
    if sensor is None:
        return {"position": {"x": 0.0, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
    return {
        "position": {"x": sensor.x_m, "y": sensor.y_m, "z": sensor.z_m},
        "orientation": {"x": 0.0, "y": 0.0, "z": sin(sensor.yaw_rad / 2), "w": cos(sensor.yaw_rad / 2)},
    }
