"""Motions in files of a robot's maker: the declaration by which a package has them read."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from math import ceil
from typing import Protocol, TypeVar

from msgspec.structs import replace

from lbr.messages.joints import KeyFrame, Motion
from lbr.messages.rows import Row
from lbr.robot.old_data import Note

R = TypeVar("R", bound=Row)
LARGEST_BYTES = 4 << 20
"""More than any motion needs; a larger file is not read."""
SHORTEST_S, LONGEST_S = 0.01, 60.0
"""The bounds of one key frame; `KeyFrame` has the upper bound."""
DIGITS = 4
"""Of an angle: a tenth of a milliradian is less than a servo's step."""


class RobotRows(Protocol):
    """The rows of one robot."""

    def of(self, row: type[R]) -> tuple[R, ...]:
        """Return the rows of a table."""


class MakersMotion(Protocol):
    """The motions of a file, before their robot is known."""

    def fits(self, rows: RobotRows) -> bool:
        """Return whether a robot has the joints of the file."""

    def motions(self, rows: RobotRows) -> tuple[tuple[Motion, ...], list[Note]]:
        """Return the motions in the angles of a robot's joints, with notes for people; raise InputError if it
        cannot."""


class ReadMotion(Protocol):
    """Reads the content of a file; raises InputError with its fault."""

    def __call__(self, content: bytes) -> MakersMotion:
        """Return the motions."""


class WriteMotion(Protocol):
    """Writes a motion as the content of a file; raises InputError with the reason if it cannot."""

    def __call__(self, motion: Motion, rows: RobotRows) -> tuple[bytes, list[Note]]:
        """Return the content, with notes for people."""


@dataclass(frozen=True, kw_only=True, slots=True)
class MotionFormat:
    """A format of motion files: the `suffix` of their names, such as `.rbm`, a `summary`, and `module:function` to read
    them.

    `write` is the function that writes one, if that is possible.
    """

    suffix: str
    summary: str
    read: str
    write: str = ""


def split(frames: Iterable[KeyFrame], longest_s: float = LONGEST_S) -> Iterator[KeyFrame]:
    """Yield key frames; long ones are split."""
    before: dict[str, float] = {}
    for frame in frames:
        parts = ceil(frame.duration_s / longest_s)
        for part in range(1, parts + 1):
            positions = {
                name: angle
                if part == parts
                else round(before.get(name, angle) + (angle - before.get(name, angle)) * part / parts, DIGITS)
                for name, angle in frame.positions.items()
            }
            yield KeyFrame(positions=positions, duration_s=frame.duration_s / parts)
        before = {**before, **frame.positions}


def sparse(frames: Iterable[KeyFrame]) -> Iterator[KeyFrame]:
    """Yield key frames without the joints that do not move."""
    at: dict[str, float] = {}
    for frame in frames:
        yield replace(
            frame, positions={name: angle for name, angle in frame.positions.items() if at.get(name) != angle}
        )
        at.update(frame.positions)


Formats = Mapping[str, MotionFormat]
"""Formats of motion files by their suffix."""
