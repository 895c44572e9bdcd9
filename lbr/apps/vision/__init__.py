"""The coloured thing or face in a camera's picture, and where it is: reported, or followed by the head.

Looking needs OpenCV, the extra `vision`, and none of it before a search begins.
"""

from lbr.component import Component

COMPONENT = Component(
    kinds={
        "sighting": "lbr.apps.vision.sighting.kind:KIND",
        "tracking": "lbr.apps.vision.tracking.kind:KIND",
    },
)
