"""UXA-90: a humanoid of one metre, with a main board and an API for phones."""

from lbr.component import Component

COMPONENT = Component(
    robots={"uxa90": "lbr.robots.uxa90.robot:ROBOT"},
    kinds={"uxa90": "lbr.robots.uxa90.driver:KIND"},
    faces={"uxa90": "lbr.robots.uxa90.rest.legacy:Uxa90Face"},
    ports={"uxa90": "lbr.robots.uxa90.rest:PORTS"},
    twins={"uxa90": "lbr.robots.uxa90.twin:TWIN"},
    needs=("simulation", "web"),
    messages=("lbr.robots.uxa90.driver.messages",),
)
