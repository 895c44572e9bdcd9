"""A rover with four driven wheels: the places of its rows and launch profiles. There is no other code."""

from pathlib import Path

from lbr.robot import Robot

HERE = Path(__file__).parent
ROBOT = Robot(
    name="rover",
    summary="four driven wheels that steer by skidding, and a lidar",
    rows=HERE / "rows.sql",
    profiles=HERE / "profiles",
)
