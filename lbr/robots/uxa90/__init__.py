"""UXA-90: a humanoid of one metre, with a main board and an API for phones."""

from lbr.component import Component

COMPONENT = Component(
    robots={"uxa90": "lbr.robots.uxa90.robot:ROBOT"},
    kinds={"uxa90": "lbr.drivers.uxa90:KIND"},
    faces={"uxa90": "lbr.apps.web.uxa90:face"},
    ports={"uxa90": "lbr.apps.web.uxa90:PORTS"},
    twins={"uxa90": "lbr.simulation.devices.uxa90:TWIN"},
    messages=("lbr.drivers.uxa90.messages",),
)
