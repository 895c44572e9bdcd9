"""The robot lbr, telepresence on two driven wheels: robot.db.sql has its rows, with the schema."""

from lbr.component import Component

COMPONENT = Component(
    robots={"lbr": "lbr.robots.lbr.robot:ROBOT"},
    kinds={"beacon": "lbr.robots.lbr.beacon:KIND"},
    faces={"lbr_original": "lbr.robots.lbr.original.routes:LbrOriginalFace"},
    ports={"lbr_original": "lbr.robots.lbr.original:PORTS"},
    needs=("web",),
)
