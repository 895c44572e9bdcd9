"""Teleop: a person drives with a gamepad at the robot's own computer, while the dead-man button is held.

`hand` interprets the gamepad, and knows neither bus nor clock; `lines` sends the lines of buttons. `capability` leases
the drive, as any other client does.
"""

from lbr.component import Component

COMPONENT = Component(kinds={"gamepad_teleop": "lbr.apps.teleop.kind:KIND"})
