"""Operations: they own the motion, between the senders of commands and the drivers that carry it out."""

from lbr.component import Component

COMPONENT = Component(
    kinds={
        "attitude": "lbr.operations.attitude:KIND",
        "battery": "lbr.operations.battery:KIND",
        "drive": "lbr.operations.drive:KIND",
        "joints": "lbr.operations.joints:KIND",
        "motions": "lbr.operations.motions:KIND",
        "odometry": "lbr.operations.odometry:KIND",
        "power": "lbr.operations.power:KIND",
    },
)
