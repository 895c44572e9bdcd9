"""SO-101 arms of Feetech STS3215 servos: the package's component."""

from lbr.component import Component

COMPONENT = Component(
    kinds={
        "feetech": "lbr_so101.kind:KIND",
        "teleop": "lbr_so101.teleop:KIND",
        "arm_calibration": "lbr_so101.calibration:KIND",
    },
    robots={"so101": "lbr_so101.robot:ROBOT"},
    twins={"feetech": "lbr_so101.twin:TWIN"},
)
