"""From a motion file of the UXA-90's maker to a motion of a robot's joints."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import ceil

from msgspec.structs import replace

from lbr.drivers.uxa90.messages import COUNT_RAD
from lbr.errors import InputError
from lbr.messages.faces import Motor
from lbr.messages.joints import Joint, KeyFrame, Motion
from lbr.robots.motion_file import RobotRows, name_from
from lbr.robots.uxa90 import rbm
from lbr.robots.uxa90.rbm import RbmFile

FACTORY = "factory"
"""The layer of the table `motor` whose `rest` are the nominal zeros."""
BEGIN_S = 1.0
"""A motion of the maker's begins where it is; ours leads there first, in this long or what the joints need."""
SHORTEST_S = 0.01
LONGEST_S = 60.0
DIGITS = 4


@dataclass(frozen=True, slots=True)
class RbmMotion:
    """A motion of the maker's, for robots whose servos' nominal zeros are in the layer `factory`."""

    file: RbmFile

    def fits(self, rows: RobotRows) -> bool:
        """Say whether a robot has nominal zeros."""
        return any(motor.layer == FACTORY for motor in rows.of(Motor))

    def motion(self, rows: RobotRows) -> tuple[Motion, list[str]]:
        """Return it in the angles of a robot's joints, and what people should know of it."""
        return of_rbm(self.file, rows)


def read(content: bytes) -> RbmMotion:
    """Return the motion in a file; InputError names the field that cannot be."""
    return RbmMotion(rbm.parse(content))


def of_rbm(file: RbmFile, rows: RobotRows) -> tuple[Motion, list[str]]:
    """Return the motion of a maker's file for a robot's joints, and what people should know about it."""
    nominal = {motor.id: motor for motor in rows.of(Motor) if motor.layer == FACTORY}
    joints = {row.device_id: row for row in rows.of(Joint) if row.device_id in nominal}
    if not joints:
        raise InputError(f"that robot has no joints with a motor in layer '{FACTORY}': name another")
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
