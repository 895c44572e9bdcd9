"""The programme of a play, step by step: a lead-in, the motion this many times, a lead-out. Pure.

A step is a key frame, or a whole motion stored in the robot's own controller.
"""

from collections.abc import Iterable, Mapping

import msgspec
from msgspec import Struct

from lbr.errors import InputError
from lbr.messages.joints import KeyFrame, Motion, PlayCommand, StoredMotion
from lbr.names import did_you_mean

LONGEST_FRAME_S = 60.0
MOST_SENT = 50
"""The most key frames in one message; joints operation computes their ways between two setpoints."""
MOST_BYTES = 40_000


class Place(Struct, frozen=True):
    """The place of a step in a programme; `frame` and `round` count from 1."""

    motion: str
    frame: int
    frames: int
    round: int


class Programme(Struct, frozen=True):
    """A motion to play, with an optional lead-in and lead-out."""

    motion: Motion
    lead_in: Motion | None
    lead_out: Motion | None
    times: int
    speed: float
    mirror: bool

    @property
    def length(self) -> int:
        """Return the number of steps."""
        return _steps(self.lead_in) + self.times * _steps(self.motion) + _steps(self.lead_out)

    @property
    def duration_s(self) -> float:
        """Return the total time, without the way to its beginning."""
        rest_s = self.times * _lasts_s(self.motion) + _lasts_s(self.lead_out)
        return (_lasts_s(self.lead_in) + rest_s) / self.speed

    def at(self, index: int) -> KeyFrame:
        """Return a key frame, counted from 0, at the played speed; for a motion of the controller its last."""
        motion, place = self._find(index)
        if motion.slot is not None:
            return KeyFrame(positions=_pose(motion), duration_s=_lasts_s(motion), stable=_stable(motion))
        frame = motion.frames[place.frame - 1]
        return KeyFrame(positions=frame.positions, duration_s=frame.duration_s / self.speed, stable=frame.stable)

    def place(self, index: int) -> Place:
        """Return the place of a step; after the end it is the last."""
        return self._find(min(index, self.length - 1))[1]

    def stored(self, index: int) -> StoredMotion | None:
        """Return the controller's motion for this step, or None if it is a key frame."""
        motion, _ = self._find(index)
        if motion.slot is None:
            return None
        return StoredMotion(
            slot=motion.slot,
            duration_s=_lasts_s(motion),
            pose=_pose(motion),
            limp=motion.limp,
            stable=_stable(motion),
        )

    def leg_end(self, start: int) -> int:
        """Return the step at which the joints come to rest after a start: the end of the key frames up to a stored
        motion."""
        if self.stored(start) is not None:
            return start + 1
        body = _steps(self.lead_in)
        parts = ((body, self.motion), (body + self.times * _steps(self.motion), self.lead_out))
        ends = (at for at, motion in parts if at > start and motion is not None and motion.slot is not None)
        return next(ends, self.length)

    def portion(self, start: int) -> tuple[KeyFrame, ...]:
        """Return the key frames from `start` on that fit into one message; empty where the controller plays."""
        if self.stored(start) is not None:
            return ()
        frames: list[KeyFrame] = []
        size = 0
        for index in range(start, min(start + MOST_SENT, self.leg_end(start))):
            frame = self.at(index)
            size += len(msgspec.json.encode(frame))
            if frames and size > MOST_BYTES:
                break
            frames.append(frame)
        return tuple(frames)

    def _find(self, index: int) -> tuple[Motion, Place]:
        before, body, after = _steps(self.lead_in), _steps(self.motion), _steps(self.lead_out)
        if self.lead_in is not None and index < before:
            return self.lead_in, Place(self.lead_in.name, index + 1, before, 1)
        index -= before
        if self.lead_out is not None and index >= self.times * body:
            return self.lead_out, Place(self.lead_out.name, index - self.times * body + 1, after, self.times)
        return self.motion, Place(self.motion.name, index % body + 1, body, index // body + 1)


def programme(motions: Iterable[Motion], command: PlayCommand) -> Programme:
    """Return the programme for a command; raise InputError with the reason if it cannot be played."""
    known = {motion.name: motion for motion in motions}
    if command.motion not in known:
        raise InputError(
            f"there is no motion '{command.motion[:40]}'; {did_you_mean(command.motion, known)}", "unknown_name"
        )
    motion = _playable(known[command.motion], command)
    lead_in, lead_out = (_lead(known, motion, name, command) for name in (motion.lead_in, motion.lead_out))
    return Programme(motion, lead_in, lead_out, command.times, command.speed, command.mirror)


def _lead(known: Mapping[str, Motion], motion: Motion, name: str, command: PlayCommand) -> Motion | None:
    if not name:
        return None
    if name not in known:
        raise InputError(
            f"motion '{motion.name}' leads from or to '{name}', and there is no such motion among the rows"
        )
    return _playable(known[name], command)


def _playable(motion: Motion, command: PlayCommand) -> Motion:
    if motion.slot is not None:
        return _as_it_is(motion, command)
    speed = command.speed
    if not motion.frames:
        raise InputError(f"motion '{motion.name}' has no key frame; capture one, or write it as a row of motion_step")
    for number, frame in enumerate(motion.frames, 1):
        if not frame.duration_s / speed <= LONGEST_FRAME_S:
            took = f"takes {frame.duration_s:g} s, {frame.duration_s / speed:g} s at speed {speed:g}"
            raise InputError(f"key frame {number} of '{motion.name}' {took}; {LONGEST_FRAME_S:g} s is the most")
    if not any(frame.positions for frame in motion.frames):
        raise InputError(f"motion '{motion.name}' names no joint in any of its key frames")
    return motion


def _as_it_is(motion: Motion, command: PlayCommand) -> Motion:
    keeps = f"motion '{motion.name}' is kept by the robot's own controller, which plays it"
    if command.speed != 1.0:
        raise InputError(f"{keeps} as fast as it is: leave speed out, or say 1")
    if command.mirror:
        raise InputError(f"{keeps} as it is: it cannot be mirrored")
    if motion.slot_s is None:
        raise InputError(f"{keeps}, and its row does not say for how long: write slot_s")
    return motion


def _steps(motion: Motion | None) -> int:
    if motion is None:
        return 0
    return len(motion.frames) if motion.slot is None else 1


def _lasts_s(motion: Motion | None) -> float:
    if motion is None:
        return 0.0
    return sum(frame.duration_s for frame in motion.frames) if motion.slot is None else motion.slot_s or 0.0


def _stable(motion: Motion) -> bool:
    """Return whether the robot stands after the last key frame."""
    return bool(motion.frames) and motion.frames[-1].stable


def _pose(motion: Motion) -> dict[str, float]:
    """Return the final pose of key frames: the last position of each joint."""
    pose: dict[str, float] = {}
    for frame in motion.frames:
        pose |= frame.positions
    return pose
