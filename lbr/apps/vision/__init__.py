"""The direction of a coloured thing or a face in a camera's picture: reported, or followed by the head.

A search needs OpenCV, the extra `vision`; nothing of it is loaded before.
"""

from lbr.component import Component

COMPONENT = Component(
    kinds={
        "sighting": "lbr.apps.vision.sighting.kind:KIND",
        "tracking": "lbr.apps.vision.tracking.kind:KIND",
    },
)
