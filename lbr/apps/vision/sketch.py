"""A picture with the target marked, and the colour of its middle, for the user who sets the colour.

Needs OpenCV, as `finding` does.
"""

from typing import NamedTuple

from lbr.apps.vision.finding import finder
from lbr.apps.vision.settings import VisionSettings
from lbr.errors import InputError
from lbr.messages.tracking import Seen, Target


class Sketch(NamedTuple):
    """The result in words, and the marked picture as JPEG."""

    text: str
    picture: bytes


def sketch(settings: VisionSettings, target: Target, data: bytes) -> Sketch:
    """Search a picture, and mark the target; raise InputError if that is not possible."""
    seen = finder(settings, target)(data)
    from lbr.apps.vision import opencv

    image = opencv.decode(data)
    if image is None:
        raise InputError("the newest picture cannot be read")
    words = f"a {target} {_where(seen)}" if seen is not None else f"no {target}"
    return Sketch(f"sees {words}; {opencv.middle(image)}", opencv.marked(image, seen))


def _where(seen: Seen) -> str:
    aside, down = ("right" if seen.x > 0 else "left"), ("below" if seen.y > 0 else "above")
    x, y, radius = (abs(value) * 100 for value in (seen.x, seen.y, seen.radius))
    return f"{x:.0f} % {aside} and {y:.0f} % {down} of the middle, of radius {radius:.1f} %"
