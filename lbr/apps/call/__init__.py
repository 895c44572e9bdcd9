"""The call: picture and sound both ways between a page and the robot, by WebRTC, in a process of its own."""

from lbr.component import Component

COMPONENT = Component(
    kinds={"call": "lbr.apps.call.kind:KIND"},
)
