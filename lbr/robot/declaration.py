"""A robot as its package declares it."""

from dataclasses import dataclass
from pathlib import Path

from lbr.robot.motion_file import MotionFormat
from lbr.robot.old_data import OldFormat


@dataclass(frozen=True, kw_only=True, slots=True)
class Robot:
    """A robot of a package: the places of its rows, launch profiles and body. Light to import; nothing is read yet.

    `name` is the row's, and the component's in its `robots`. `rows` is a file of SQL that inserts rows of this robot,
    and phrases; a robot without one has its rows in every new database. `profiles` is a folder of launch profiles, each
    named like the robot, or with a suffix after a dash: `my-robot.toml`, `my-robot-sim.toml`. `body` is its MuJoCo
    description, which the setting `model` of a simulated world names by the robot's name. `motion_formats` are its
    maker's motion files, for `lbr motion import`, `old_formats` other files of its former programs, for `lbr import`.
    """

    name: str
    summary: str
    rows: Path | None = None
    profiles: Path | None = None
    body: Path | None = None
    motion_formats: tuple[MotionFormat, ...] = ()
    old_formats: tuple[OldFormat, ...] = ()
