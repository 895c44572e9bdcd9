"""Teleop: a person drives with a gamepad at the robot's own computer, for as long as the dead-man button is held.

`hand` says what a gamepad means, and knows neither bus nor clock; `lines` says what buttons say; `capability` borrows
the motion, by a lease of the drive like anyone.
"""

from lbr.component import Component

COMPONENT = Component(
    kinds={"gamepad_teleop": "lbr.apps.teleop.kind:KIND"},
)
