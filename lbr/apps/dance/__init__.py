"""Dance: plays a song and moves the base to its beats, as anybody else would: by commands with a lease."""

from lbr.component import Component

COMPONENT = Component(
    kinds={"dance": "lbr.apps.dance.kind:KIND"},
    messages=("lbr.apps.dance.messages",),
)
