"""Motions in files of a robot's maker: what a package declares to have them read."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, TypeVar

from lbr.messages.joints import Motion
from lbr.messages.rows import Row

R = TypeVar("R", bound=Row)
LARGEST_BYTES = 4 << 20
"""More than any motion needs; a file that is larger is not read."""
LONGEST_NAME = 40
_NO_NAME = re.compile(r"[^a-z0-9]+")


class RobotRows(Protocol):
    """The rows of one robot."""

    def of(self, row: type[R]) -> tuple[R, ...]:
        """Return the rows of a table."""


class MakersMotion(Protocol):
    """A motion out of a file, before it is known for which robot."""

    def fits(self, rows: RobotRows) -> bool:
        """Say whether a robot has what the file speaks of."""

    def motion(self, rows: RobotRows) -> tuple[Motion, list[str]]:
        """Return it in the angles of a robot's joints, and what people should know of it; InputError says why not."""


class ReadMotion(Protocol):
    """Reads the content of a file; InputError names what is wrong in it."""

    def __call__(self, content: bytes) -> MakersMotion:
        """Return the motion."""


@dataclass(frozen=True, kw_only=True, slots=True)
class MotionFormat:
    """A format of motion files: the `suffix` of their names, such as `.rbm`, a `summary`, and `module:function` that reads them."""

    suffix: str
    summary: str
    read: str


def name_from(text: str) -> str:
    """Return a name for a row that is as much like a text as can be."""
    found = _NO_NAME.sub("_", text.lower()).strip("_")[:LONGEST_NAME].rstrip("_")
    return found if found[:1].isalpha() else f"motion_{found}"[:LONGEST_NAME].rstrip("_")


Formats = Mapping[str, MotionFormat]
"""Formats of motion files by their suffix."""
