"""The robot for Foxglove: every stream by its schema, its cameras and its body in space, its words as services.

`protocol` is Foxglove's WebSocket protocol, `channels` what is shown and of which streams it is made, `scene` the body,
`schemas` what else Foxglove has a schema for, `services` the robot's words: all of these are pure. `socket` serves one
client, `pictures` hears cameras that somebody looks at, `layout` writes layouts, and `capability` is the process.
"""

from lbr.component import Component

COMPONENT = Component(
    kinds={"foxglove": "lbr.apps.foxglove.kind:KIND"},
    needs=("web",),
    messages=("lbr.apps.foxglove.messages",),
)
