"""A small robot to try the driver on: two driven wheels on a RoboClaw."""

from pathlib import Path

from lbr.robot import Robot

HERE = Path(__file__).parent
ROBOT = Robot(
    name="claw",
    summary="two driven wheels on a RoboClaw",
    rows=HERE / "rows.sql",
    profiles=HERE / "profiles",
)
