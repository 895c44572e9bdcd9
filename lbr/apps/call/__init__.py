"""The call: picture and sound both ways between a page and the robot, by WebRTC, in a process of its own."""

from lbr.component import Component

COMPONENT = Component(
    kinds={"call": "lbr.apps.call.kind:KIND"},
    faces={"call": "lbr.apps.call.face.routes:CallFace"},
    ports={"call": "lbr.apps.call.face:PORTS"},
    needs=("web",),
    messages=("lbr.apps.call.messages",),
)
