"""RoboClaw 2x motor controllers by packet serial: the package's component."""

from lbr.component import Component

COMPONENT = Component(
    kinds={"roboclaw": "lbr_roboclaw.kind:KIND"},
    robots={"claw": "lbr_roboclaw.bench:ROBOT"},
    twins={"roboclaw": "lbr_roboclaw.twin:TWIN"},
)
