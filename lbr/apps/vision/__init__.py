"""What a camera's picture shows of a coloured thing or a face, and where that is: told, or followed by the head.

What looks needs OpenCV, the extra `vision`, and none of it before something is looked for.
"""

from lbr.component import Component

COMPONENT = Component(
    kinds={
        "sighting": "lbr.apps.vision.sighting.kind:KIND",
        "tracking": "lbr.apps.vision.tracking.kind:KIND",
    },
)
