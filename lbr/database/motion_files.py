"""Motions in files: a robot's own in JSON, and those of the UXA-90's maker; from there to rows, within the joints' limits."""

import re
from collections.abc import Iterable, Mapping
from math import ceil
from typing import Literal, NamedTuple

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from lbr.database import rbm
from lbr.database.rows import RobotRows
from lbr.errors import InputError
from lbr.messages.faces import Motor
from lbr.messages.joints import Joint, KeyFrame, Motion
from lbr.messages.uxa90 import COUNT_RAD

FACTORY = "factory"
"""The layer of the table `motor` whose `rest` are the nominal zeros."""
BEGIN_S = 1.0
"""A motion of the maker's begins where it is; ours leads there first, in so long or what the joints need."""
SHORTEST_S = 0.01
LONGEST_S = 60.0
DIGITS = 4
_NO_NAME = re.compile(r"[^a-z0-9]+")


class MotionFile(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="format", tag="lbr-motion"):
    """A motion as a file to share; `robot` is whose joints it names."""

    robot: str
    motion: Motion
    version: Literal[1] = 1


class Summary(NamedTuple):
    """What a motion asks for: `fastest` joint, how fast, and how fast it may be; `clipped` is how often it was cut."""

    frames: int
    duration_s: float
    joints: int
    fastest: str
    speed_rps: float
    limit_rps: float
    clipped: int


def exported(robot: str, motion: Motion) -> bytes:
    """Return a motion as the content of a file; InputError if the controller keeps it."""
    if motion.slot is not None:
        raise InputError(
            f"'{motion.name}' is kept by the robot's controller, in slot {motion.slot}: there is no more of it"
        )
    found = MotionFile(robot=robot, motion=replace(motion, builtin=False))
    return msgspec.json.format(msgspec.json.encode(found), indent=1) + b"\n"


def read(content: bytes) -> MotionFile | rbm.RbmFile:
    """Return what is in a file of either kind; InputError says what is wrong with it."""
    if content.lstrip()[:1] != b"{":
        return rbm.parse(content)
    if len(content) > rbm.MOST_BYTES:
        raise InputError(f"it has {len(content)} bytes, and a motion file has {rbm.MOST_BYTES} at most")
    try:
        return msgspec.json.decode(content, type=MotionFile)
    except (msgspec.DecodeError, RecursionError) as err:
        raise InputError(f"it is no motion: {err}") from err


def of_rbm(file: rbm.RbmFile, rows: RobotRows) -> tuple[Motion, list[str]]:
    """Return the motion of a maker's file for a robot's joints, and what people should know about it."""
    nominal = {motor.id: motor for motor in rows.of(Motor) if motor.layer == FACTORY}
    joints = {row.device_id: row for row in rows.of(Joint) if row.device_id in nominal}
    if not joints:
        raise InputError(f"robot '{rows.robot.name}' has no joints with a motor in layer '{FACTORY}': name another")
    notes = _other_zeros(file.zeros, nominal)
    frames = [_frame({move.id: move.start for move in file.scenes[0].moves}, BEGIN_S, joints, nominal)]
    at = {move.id: move.start for move in file.scenes[0].moves}
    for number, scene in enumerate(file.scenes, 1):
        begin = {move.id: move.start for move in scene.moves}
        apart = [joints[servo].name for servo in joints if begin.get(servo) != at.get(servo)]
        if apart:
            notes.append(f"scene {number} does not begin where the one before ends ({', '.join(apart[:3])}): led there")
            frames.append(_frame(begin, SHORTEST_S, joints, nominal))
        at = {move.id: move.end for move in scene.moves}
        frames.append(_frame(at, max(SHORTEST_S, scene.transition_s), joints, nominal))
    return Motion(name=name_from(file.name), frames=tuple(_sparse(_split(frames))), help=file.name[:200]), notes


def name_from(text: str) -> str:
    """Return a name for a row that is as much like a text as can be."""
    found = _NO_NAME.sub("_", text.lower()).strip("_")[:40].rstrip("_")
    return found if found[:1].isalpha() else f"motion_{found}"[:40].rstrip("_")


def within_limits(motion: Motion, joints: Iterable[Joint], *, clip: bool) -> tuple[Motion, int]:
    """Return the motion with every angle within its joint's limits, and how many were cut; InputError unless `clip`."""
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
        said = "; ".join(
            f"{name}: {angle:.3f} is outside {row.lower_rad:g} to {row.upper_rad:g}"
            for name, (row, angle) in worst.items()
        )
        raise InputError(f"joints would go beyond their limits: {said}. --clip brings them within")
    frames = tuple(
        replace(frame, positions={name: _clipped(angle, rows[name]) for name, angle in frame.positions.items()})
        for frame in motion.frames
    )
    return replace(motion, frames=frames), len(beyond)


def summary(motion: Motion, joints: Iterable[Joint], clipped: int = 0) -> Summary:
    """Return what a motion asks for, from its first key frame on; InputError if it moves nothing."""
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


def _other_zeros(zeros: Mapping[int, int], nominal: Mapping[int, Motor]) -> list[str]:
    other = [
        f"{servo} ({zeros[servo]}, not {row.rest})"
        for servo, row in nominal.items()
        if zeros.get(servo, row.rest) != row.rest
    ]
    return [f"the file's zeros differ from the nominal ones, which count: servo {', '.join(other)}"] if other else []


def _frame(
    counts: Mapping[int, int], duration_s: float, joints: Mapping[int, Joint], nominal: Mapping[int, Motor]
) -> KeyFrame:
    """Return a key frame in the joints' angles: a count more is the same angle whatever a robot's own zero is."""
    positions = {
        row.name: round(row.sign * (counts[servo] - nominal[servo].rest) * COUNT_RAD, DIGITS) + 0.0
        for servo, row in joints.items()
        if servo in counts
    }
    return KeyFrame(positions=positions, duration_s=duration_s)


def _split(frames: Iterable[KeyFrame]) -> Iterable[KeyFrame]:
    """Yield the frames, those that take too long for one row in parts."""
    before: dict[str, float] = {}
    for frame in frames:
        parts = ceil(frame.duration_s / LONGEST_S)
        for part in range(1, parts + 1):
            positions = {
                name: angle
                if part == parts
                else round(before.get(name, angle) + (angle - before.get(name, angle)) * part / parts, DIGITS)
                for name, angle in frame.positions.items()
            }
            yield KeyFrame(positions=positions, duration_s=frame.duration_s / parts)
        before = {**before, **frame.positions}


def _sparse(frames: Iterable[KeyFrame]) -> Iterable[KeyFrame]:
    """Yield the frames without the joints that stay where they are."""
    at: dict[str, float] = {}
    for frame in frames:
        yield replace(
            frame, positions={name: angle for name, angle in frame.positions.items() if at.get(name) != angle}
        )
        at.update(frame.positions)
