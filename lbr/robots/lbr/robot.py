"""The robot lbr, telepresence on two driven wheels: robot.db.sql has its rows, with the schema."""

from lbr.resources import launch_profiles
from lbr.robot.declaration import Robot
from lbr.robot.old_data import OldFormat

ROBOT = Robot(
    name="lbr",
    summary="telepresence on two driven wheels",
    profiles=launch_profiles(),
    old_formats=(
        OldFormat(
            name="lbr-database",
            summary="the first lbr's database, robot.sqlite3 or its SQL",
            read="lbr.robots.lbr.old_database:read",
        ),
        OldFormat(
            name="lbr-cameras",
            summary="the first lbr's cameras, as its API told them",
            read="lbr.robots.lbr.old_cameras:read",
        ),
    ),
)
