"""What is played, key frame by key frame: a lead-in, the motion so many times, a lead-out. Pure."""

from collections.abc import Iterable, Mapping

import msgspec
from msgspec import Struct

from lbr.capability.near import near
from lbr.errors import InputError
from lbr.messages.joints import KeyFrame, Motion, PlayCommand

LONGEST_FRAME_S = 60.0
MOST_SENT = 50
"""Key frames in one message; joints operation computes their ways between two setpoints."""
MOST_BYTES = 40_000


class Place(Struct, frozen=True):
    """Where in a programme a key frame is; `frame` and `round` count from 1."""

    motion: str
    frame: int
    frames: int
    round: int


class Programme(Struct, frozen=True):
    """A motion as it is to be played, with a lead-in and a lead-out that may be empty.

    Its first key frame takes `reach_s` at least: the joints may be far from it.
    """

    motion: Motion
    lead_in: Motion | None
    lead_out: Motion | None
    times: int
    speed: float
    mirror: bool
    reach_s: float = 0.0

    @property
    def length(self) -> int:
        """How many key frames there are."""
        return len(_of(self.lead_in)) + self.times * len(self.motion.frames) + len(_of(self.lead_out))

    def at(self, index: int) -> KeyFrame:
        """Return a key frame, counted from 0, as fast as it is to be played."""
        motion, place = self._find(index)
        frame = motion.frames[place.frame - 1]
        duration_s = max(frame.duration_s / self.speed, 0.0 if index else self.reach_s)
        return KeyFrame(positions=frame.positions, duration_s=duration_s)

    def place(self, index: int) -> Place:
        """Return where a key frame is; after the last, it is the last."""
        return self._find(min(index, self.length - 1))[1]

    def portion(self, start: int) -> tuple[KeyFrame, ...]:
        """Return the key frames from `start` on that fit into one message."""
        found: list[KeyFrame] = []
        size = 0
        for index in range(start, min(start + MOST_SENT, self.length)):
            frame = self.at(index)
            size += len(msgspec.json.encode(frame))
            if found and size > MOST_BYTES:
                break
            found.append(frame)
        return tuple(found)

    def _find(self, index: int) -> tuple[Motion, Place]:
        before, body, after = _of(self.lead_in), self.motion.frames, _of(self.lead_out)
        if self.lead_in is not None and index < len(before):
            return self.lead_in, Place(self.lead_in.name, index + 1, len(before), 1)
        index -= len(before)
        if self.lead_out is not None and index >= self.times * len(body):
            return self.lead_out, Place(self.lead_out.name, index - self.times * len(body) + 1, len(after), self.times)
        return self.motion, Place(self.motion.name, index % len(body) + 1, len(body), index // len(body) + 1)


def programme(motions: Iterable[Motion], command: PlayCommand) -> Programme:
    """Return what a command wants to be played; raise InputError saying why it cannot be."""
    known = {motion.name: motion for motion in motions}
    if command.motion not in known:
        raise InputError(f"there is no motion '{command.motion[:40]}'; {near(command.motion, known)}")
    motion = _playable(known[command.motion], command.speed)
    lead_in, lead_out = (_lead(known, motion, name, command.speed) for name in (motion.lead_in, motion.lead_out))
    return Programme(motion, lead_in, lead_out, command.times, command.speed, command.mirror)


def _lead(known: Mapping[str, Motion], motion: Motion, name: str, speed: float) -> Motion | None:
    if not name:
        return None
    if name not in known:
        raise InputError(
            f"motion '{motion.name}' leads from or to '{name}', and there is no such motion among the rows"
        )
    return _playable(known[name], speed)


def _playable(motion: Motion, speed: float) -> Motion:
    if not motion.frames:
        raise InputError(f"motion '{motion.name}' has no key frame; capture one, or write it as a row of motion_step")
    for number, frame in enumerate(motion.frames, 1):
        if not frame.duration_s / speed <= LONGEST_FRAME_S:
            took = f"takes {frame.duration_s:g} s, {frame.duration_s / speed:g} s at speed {speed:g}"
            raise InputError(f"key frame {number} of '{motion.name}' {took}; {LONGEST_FRAME_S:g} s is the most")
    if not any(frame.positions for frame in motion.frames):
        raise InputError(f"motion '{motion.name}' names no joint in any of its key frames")
    return motion


def _of(motion: Motion | None) -> tuple[KeyFrame, ...]:
    return motion.frames if motion is not None else ()
