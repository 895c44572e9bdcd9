"""A rover with four driven wheels: the package's component."""

from lbr.component import Component

COMPONENT = Component(
    robots={"rover": "lbr_rover.robot:ROBOT"},
)
