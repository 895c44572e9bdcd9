"""UXA-90: a humanoid of one metre, with a main board and an API for phones."""

from pathlib import Path

from lbr.robot.declaration import Robot
from lbr.robot.motion_file import MotionFormat
from lbr.robot.old_data import OldFormat

_HERE = Path(__file__).parent
ROBOT = Robot(
    name="uxa90",
    summary="a humanoid of one metre, with an API for phones",
    rows=_HERE / "rows.sql",
    profiles=_HERE / "profiles",
    body=_HERE / "body.xml",
    motion_formats=(
        MotionFormat(
            suffix=".rbm",
            summary="of the UXA-90's maker",
            read="lbr.robots.uxa90.motion_file:read",
            write="lbr.robots.uxa90.motion_file:write",
        ),
    ),
    old_formats=(
        OldFormat(
            name="uxa90-tables",
            summary="motors and motions as the first API told them, in JSON",
            read="lbr.robots.uxa90.old_tables:read",
        ),
        OldFormat(
            name="uxa90-settings",
            summary="the first API's .env",
            read="lbr.robots.uxa90.old_tables:read_settings",
        ),
    ),
)
