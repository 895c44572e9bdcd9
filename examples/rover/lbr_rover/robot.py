"""A rover with four driven wheels: where its rows and launch profiles are. There is no other code."""

from pathlib import Path

from lbr.robot import Robot

HERE = Path(__file__).parent
ROBOT = Robot(
    name="rover",
    summary="four driven wheels that steer by skidding, and a lidar",
    rows=HERE / "rows.sql",
    profiles=HERE / "profiles",
)
