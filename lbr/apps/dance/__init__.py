"""Dance: plays a song and moves the base to its beats, by commands under a lease, as any other client."""

from lbr.component import Component

COMPONENT = Component(kinds={"dance": "lbr.apps.dance.kind:KIND"}, messages=("lbr.apps.dance.messages",))
