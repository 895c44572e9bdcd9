"""The door to other machines: a router of its own, with tokens, and a relay for messages that may move the robot."""

from lbr.component import Component

COMPONENT = Component(kinds={"lan": "lbr.apps.lan.kind:KIND"})
