"""A rover with four driven wheels: what the package brings to lbr."""

from lbr.component import Component

COMPONENT = Component(
    robots={"rover": "lbr_rover.robot:ROBOT"},
)
