"""Bioloid: a humanoid of eighteen AX-12A servos."""

from pathlib import Path

from lbr.robot.declaration import Robot
from lbr.robot.motion_file import MotionFormat

_HERE = Path(__file__).parent
ROBOT = Robot(
    name="bioloid",
    summary="a humanoid of eighteen Dynamixel servos",
    rows=_HERE / "rows.sql",
    profiles=_HERE / "profiles",
    body=_HERE / "body.xml",
    motion_formats=(
        MotionFormat(
            suffix=".mtn",
            summary="of RoboPlus",
            read="lbr.robots.bioloid.motion_file:read",
            write="lbr.robots.bioloid.motion_file:write",
        ),
    ),
)
