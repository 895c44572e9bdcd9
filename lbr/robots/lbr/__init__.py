"""The robot lbr, telepresence on two driven wheels: its rows stand with the schema in robot.db.sql."""

from lbr.component import Component

COMPONENT = Component(
    robots={"lbr": "lbr.robots.lbr.robot:ROBOT"},
    faces={"lbr_original": "lbr.apps.web.lbr_original:face"},
    ports={"lbr_original": "lbr.apps.web.lbr_original:PORTS"},
)
