"""Motions in files: in JSON, and in the forms of robots' makers; and as rows within the joints' limits."""

from collections.abc import Iterable
from typing import Literal, NamedTuple

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from lbr import plugins
from lbr.errors import InputError
from lbr.messages.joints import MAX_FRAMES, Joint, KeyFrame, Motion
from lbr.messages.unreadable import UNREADABLE
from lbr.robot import registry
from lbr.robot.motion_file import LARGEST_BYTES, MakersMotion, ReadMotion, RobotRows, WriteMotion
from lbr.robot.old_data import Note


class MotionFile(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="format", tag="lbr-motion"):
    """A motion as a file to share; `robot` is the robot of its joints."""

    robot: str
    motion: Motion
    version: Literal[1] = 1


class Summary(NamedTuple):
    """The demands of a motion: its `fastest` joint, with speed and limit; `clipped` counts the clipped angles."""

    frames: int
    duration_s: float
    joints: int
    fastest: str
    speed_rps: float
    limit_rps: float
    clipped: int


def exported(robot: str, motion: Motion, rows: RobotRows, suffix: str = "") -> tuple[bytes, list[Note]]:
    """Return a motion as the content of a file, in a maker's form by its suffix, and what that form cannot express.

    Raise InputError if the controller stores the motion, or if files of that suffix are only read.
    """
    if motion.slot is not None:
        raise InputError(
            f"'{motion.name}' is kept by the robot's controller, in slot {motion.slot}: there is no more of it"
        )
    makers = registry.motion_formats().get(suffix.lower())
    if makers is None:
        found = MotionFile(robot=robot, motion=replace(motion, builtin=False))
        return msgspec.json.format(msgspec.json.encode(found), indent=1) + b"\n", []
    if not makers.write:
        raise InputError(
            f"files of the form {makers.suffix} ({makers.summary}) are read here, not written: name a .json"
        )
    writer: WriteMotion = plugins.load(makers.write)
    return writer(motion, rows)


def read(content: bytes, suffix: str = "") -> MotionFile | MakersMotion:
    """Parse a file, by the suffix of its name; raise InputError with its fault."""
    if len(content) > LARGEST_BYTES:
        raise InputError(f"it has {len(content)} bytes, and a motion file has {LARGEST_BYTES} at most")
    if (found := registry.motion_formats().get(suffix.lower())) is not None:
        reader: ReadMotion = plugins.load(found.read)
        return reader(content)
    try:
        return msgspec.json.decode(content, type=MotionFile)
    except UNREADABLE as err:
        others = "".join(f", {suffix} ({one.summary})" for suffix, one in sorted(registry.motion_formats().items()))
        raise InputError(f"it is not a motion: {err}. Motions are in JSON{others}") from err


def within_limits(motion: Motion, joints: Iterable[Joint], *, clip: bool) -> tuple[Motion, int]:
    """Return the motion within its joints' limits, and the number of clipped angles; InputError without `clip`."""
    if len(motion.frames) > MAX_FRAMES:
        raise InputError(f"motion '{motion.name}' has {len(motion.frames)} key frames, and {MAX_FRAMES} may be")
    rows = {row.name: row for row in joints}
    for name in (name for frame in motion.frames for name in frame.positions if name not in rows):
        raise InputError(f"there is no joint '{name}' here: there are {', '.join(rows) or 'none'}", "unknown_name")
    beyond = [
        (rows[name], angle)
        for frame in motion.frames
        for name, angle in frame.positions.items()
        if angle != _clipped(angle, rows[name])
    ]
    if beyond and not clip:
        worst = {row.name: (row, angle) for row, angle in sorted(beyond, key=_excess)}
        angles = "; ".join(
            f"{name}: {angle:.3f} is outside {row.lower_rad:g} to {row.upper_rad:g}"
            for name, (row, angle) in worst.items()
        )
        raise InputError(f"joints would go beyond their limits: {angles}. --clip brings them within")
    frames = tuple(_within(frame, rows) for frame in motion.frames)
    return replace(motion, frames=frames), len(beyond)


def _within(frame: KeyFrame, rows: dict[str, Joint]) -> KeyFrame:
    """Return a key frame within the limits; a clipped one is no longer known to be stable."""
    positions = {name: _clipped(angle, rows[name]) for name, angle in frame.positions.items()}
    return replace(frame, positions=positions, stable=frame.stable and positions == frame.positions)


def summary(motion: Motion, joints: Iterable[Joint], clipped: int = 0) -> Summary:
    """Return the demands of a motion from its first key frame on; raise InputError if it moves nothing."""
    rows = {row.name: row for row in joints}
    at: dict[str, float] = {}
    worst = ("", 0.0, 0.0)
    for frame in motion.frames:
        for name, angle in frame.positions.items():
            speed, limit = abs(angle - at.get(name, angle)) / frame.duration_s, rows[name].speed_rps
            if not worst[0] or speed / limit > worst[1] / worst[2]:
                worst = (name, speed, limit)
        at.update(frame.positions)
    if not at:
        raise InputError(f"motion '{motion.name}' moves no joint")
    seconds = sum(frame.duration_s for frame in motion.frames)
    return Summary(len(motion.frames), round(seconds, 2), len(at), *worst, clipped)


def _clipped(angle: float, row: Joint) -> float:
    return min(max(angle, row.lower_rad), row.upper_rad)


def _excess(beyond: tuple[Joint, float]) -> float:
    row, angle = beyond
    return abs(angle - _clipped(angle, row))
