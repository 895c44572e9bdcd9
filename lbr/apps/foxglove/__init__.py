"""The robot for Foxglove: every stream by its schema, its cameras and its body in space, its words as services.

Pure modules: `protocol` (Foxglove's WebSocket protocol), `channels` (streams as channels), `scene` (the body),
`schemas` (messages in Foxglove's own schemas), `services` (the robot's words) and `layout`. `socket` serves one client,
`pictures` subscribes to watched cameras, and `capability` is the process.
"""

from lbr.component import Component

COMPONENT = Component(
    kinds={"foxglove": "lbr.apps.foxglove.kind:KIND"},
    needs=("web",),
    messages=("lbr.apps.foxglove.messages",),
)
