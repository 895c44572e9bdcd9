"""Bioloid: a humanoid of eighteen AX-12A servos."""

from lbr.component import Component

COMPONENT = Component(robots={"bioloid": "lbr.robots.bioloid.robot:ROBOT"})
