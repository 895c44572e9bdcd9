"""Conversion between motion files of the UXA-90's maker and motions of a robot's joints."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from lbr.errors import InputError
from lbr.messages.faces import Motor
from lbr.messages.joints import Joint, KeyFrame, Motion
from lbr.names import name_from
from lbr.robot.motion_file import DIGITS, SHORTEST_S, RobotRows, sparse, split
from lbr.robot.old_data import Note, no_place
from lbr.robots.uxa90 import rbm
from lbr.robots.uxa90.driver.messages import COUNT_RAD
from lbr.robots.uxa90.rbm import MOST_COUNTS, RbmFile, Scene, ServoMove

FACTORY = "factory"
"""The layer of the table `motor` whose `rest` are the nominal zeros."""
STEP_S, TORQUE = 0.02, 2
"""A player's step, and the maker's own torque for moving servos."""
BEGIN_S = 1.0
"""The least time to the first pose: a maker's motion starts in it, ours first leads there."""


@dataclass(frozen=True, slots=True)
class RbmMotion:
    """A motion of the maker's, for robots whose servos' nominal zeros are in the layer `factory`."""

    file: RbmFile

    def fits(self, rows: RobotRows) -> bool:
        """Return whether a robot has nominal zeros."""
        return any(motor.layer == FACTORY for motor in rows.of(Motor))

    def motions(self, rows: RobotRows) -> tuple[tuple[Motion, ...], list[Note]]:
        """Return it in the angles of a robot's joints, with notes for people."""
        motion, notes = of_rbm(self.file, rows)
        return (motion,), notes


def read(content: bytes) -> RbmMotion:
    """Return the motion in a file; raise InputError naming an invalid field."""
    return RbmMotion(rbm.parse(content))


def of_rbm(file: RbmFile, rows: RobotRows) -> tuple[Motion, list[Note]]:
    """Return the motion of a maker's file for a robot's joints, with notes for people."""
    nominal = {motor.id: motor for motor in rows.of(Motor) if motor.layer == FACTORY}
    joints = {row.device_id: row for row in rows.of(Joint) if row.device_id in nominal}
    if not joints:
        raise InputError(f"that robot has no joints with a motor in layer '{FACTORY}': name another")
    name = name_from(file.name, "motion")
    notes = _other_zeros(name, file.zeros, nominal)
    frames = [_frame({move.id: move.start for move in file.scenes[0].moves}, BEGIN_S, joints, nominal)]
    at = {move.id: move.start for move in file.scenes[0].moves}
    for number, scene in enumerate(file.scenes, 1):
        begin = {move.id: move.start for move in scene.moves}
        apart = [joints[servo].name for servo in joints if begin.get(servo) != at.get(servo)]
        if apart:
            text = f"scene {number} does not begin where the one before ends ({', '.join(apart[:3])}): led there"
            notes.append(Note("changed", "scene", name, "start", text))
            frames.append(_frame(begin, SHORTEST_S, joints, nominal))
        at = {move.id: move.end for move in scene.moves}
        frames.append(_frame(at, max(SHORTEST_S, scene.transition_s), joints, nominal))
    notes.append(no_place("servo", name, "gains, torque", "a motion here has no gains and no torque of its own"))
    return Motion(name=name, frames=tuple(sparse(split(frames))), help=file.name[:200]), notes


def write(motion: Motion, rows: RobotRows) -> tuple[bytes, list[Note]]:
    """Return a motion as a file of the maker's, with notes on losses; raise InputError for a joint without a motor."""
    nominal = {motor.id: motor for motor in rows.of(Motor) if motor.layer == FACTORY}
    joints = {row.name: row for row in rows.of(Joint) if row.device_id in nominal}
    used = {name for frame in motion.frames for name in frame.positions}
    if missing := sorted(used - set(joints)):
        raise InputError(f"joint '{missing[0]}' has no motor in layer '{FACTORY}', and such a file has no other")
    at = {servo: row.rest for servo, row in nominal.items()}
    beyond: set[str] = set()
    poses: list[dict[int, int]] = []
    for frame in motion.frames:
        for name, angle in frame.positions.items():
            count = nominal[joints[name].device_id].rest + round(joints[name].sign * angle / COUNT_RAD)
            at[joints[name].device_id] = min(MOST_COUNTS, max(0, count))
            beyond |= {name} if at[joints[name].device_id] != count else set()
        poses.append(dict(at))
    begins, ends = (poses[:1], poses[1:]) if len(poses) > 1 else (poses, poses)
    durations = [frame.duration_s for frame in motion.frames][-len(ends) :]
    scenes = tuple(
        Scene(
            f"{number}",
            max(1, round(duration_s / STEP_S)),
            duration_s,
            tuple(ServoMove(servo, before[servo], pose[servo], TORQUE) for servo in nominal),
        )
        for number, (before, pose, duration_s) in enumerate(zip((*begins, *ends), ends, durations, strict=False), 1)
    )
    zeros = {servo: row.rest for servo, row in nominal.items()}
    return rbm.write(RbmFile(motion.name, "", "0" * 13, zeros, scenes)), _losses(motion, beyond)


def _losses(motion: Motion, beyond: Collection[str]) -> list[Note]:
    """Return notes on the parts of a motion that a file cannot hold."""
    name = motion.name
    notes = [
        Note("changed", "scene", name, "positions", "a scene names all servos: others stand at their nominal zero"),
        Note("changed", "servo", name, "gains", "all servos have the same: set yours in the maker's program"),
    ]
    if len(motion.frames) > 1 and motion.frames[0].duration_s != BEGIN_S:
        text = f"it begins in its first pose: the {motion.frames[0].duration_s:g} s to get there have no place"
        notes.append(no_place("scene", name, "transition", text))
    if beyond:
        text = f"{', '.join(sorted(beyond))} would go beyond 0 to {MOST_COUNTS} counts, and end there"
        notes.append(Note("changed", "scene", name, "end", text))
    if motion.lead_in or motion.lead_out:
        notes.append(no_place("motion", name, "lead_in, lead_out", "what is played before and after"))
    return notes


def _other_zeros(name: str, zeros: Mapping[int, int], nominal: Mapping[int, Motor]) -> list[Note]:
    differing = [
        f"{servo} ({zeros[servo]}, not {row.rest})"
        for servo, row in nominal.items()
        if zeros.get(servo, row.rest) != row.rest
    ]
    text = f"the file's zeros differ from the nominal ones, which count: servo {', '.join(differing)}"
    return [no_place("servo", name, "zero", text)] if differing else []


def _frame(
    counts: Mapping[int, int], duration_s: float, joints: Mapping[int, Joint], nominal: Mapping[int, Motor]
) -> KeyFrame:
    """Return a key frame in the joints' angles: a count is the same angle whatever a robot's own zero is."""
    positions = {
        row.name: round(row.sign * (counts[servo] - nominal[servo].rest) * COUNT_RAD, DIGITS) + 0.0
        for servo, row in joints.items()
        if servo in counts
    }
    return KeyFrame(positions=positions, duration_s=duration_s)
