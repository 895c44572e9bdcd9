"""The robot lbr, telepresence on two driven wheels: its rows stand with the schema in robot.db.sql."""

from lbr.resources import launch_profiles
from lbr.robots.robot import Robot

ROBOT = Robot(name="lbr", summary="telepresence on two driven wheels", profiles=launch_profiles())
