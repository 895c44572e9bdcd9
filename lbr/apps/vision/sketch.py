"""A picture with what is seen in it marked, and what colour its middle has: for the user who sets the colour to look
for.

Needs OpenCV, as `finding` does.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

from lbr.apps.vision.finding import decode, finder
from lbr.apps.vision.settings import VisionSettings
from lbr.errors import InputError
from lbr.messages.tracking import Seen, Target

if TYPE_CHECKING:
    import numpy as np

    Image = np.ndarray[Any, Any]

MIDDLE = 0.04
"""The middle is a square of twice this share of the width; what is held there should fill it."""
USUAL_PERCENT = (5.0, 95.0)
SEEN_COLOUR, MIDDLE_COLOUR = (0, 255, 0), (255, 255, 255)


class Sketch(NamedTuple):
    """What was seen, in words, and the marked picture as JPEG."""

    text: str
    picture: bytes


def sketch(settings: VisionSettings, target: Target, data: bytes) -> Sketch:
    """Look at a picture; raise InputError if that cannot be."""
    seen = finder(settings, target)(data)
    image = decode(data)
    if image is None:
        raise InputError("the newest picture cannot be read")
    words = f"a {target} {_where(seen)}" if seen is not None else f"no {target}"
    return Sketch(f"sees {words}; {_middle(image)}", _marked(image, seen))


def _where(seen: Seen) -> str:
    aside, down = ("right" if seen.x > 0 else "left"), ("below" if seen.y > 0 else "above")
    x, y, radius = (abs(value) * 100 for value in (seen.x, seen.y, seen.radius))
    return f"{x:.0f} % {aside} and {y:.0f} % {down} of the middle, of radius {radius:.1f} %"


def _middle(image: "Image") -> str:
    """Return the colours of the middle; hues go round, so they are taken as far from the most frequent one."""
    import cv2  # noqa: PLC0415 - an extra
    import numpy as np  # noqa: PLC0415

    height, width = image.shape[:2]
    half = max(1, round(MIDDLE * width))
    part = image[max(0, height // 2 - half) : height // 2 + half, max(0, width // 2 - half) : width // 2 + half]
    hsv = cv2.cvtColor(part, cv2.COLOR_BGR2HSV).reshape(-1, 3).astype(float)
    usual = float(np.bincount(hsv[:, 0].astype(int), minlength=180).argmax()) * 2.0
    hues = (hsv[:, 0] * 2.0 - usual + 180.0) % 360.0 - 180.0
    low, high = (float(value + usual) % 360.0 for value in np.percentile(hues, USUAL_PERCENT))
    saturations, values = (np.percentile(hsv[:, axis] / 2.55, USUAL_PERCENT) for axis in (1, 2))
    return (
        f"the middle has hue {low:.0f} to {high:.0f} degrees, saturation {saturations[0]:.0f} to {saturations[1]:.0f} "
        f"and value {values[0]:.0f} to {values[1]:.0f} percent"
    )


def _marked(image: "Image", seen: Seen | None) -> bytes:
    import cv2  # noqa: PLC0415

    height, width = image.shape[:2]
    middle, half = (width // 2, height // 2), max(1, round(MIDDLE * width))
    corners = [(middle[0] + side * half, middle[1] + side * half) for side in (-1, 1)]
    cv2.rectangle(image, corners[0], corners[1], MIDDLE_COLOUR, 1)
    if seen is not None:
        at = (round((seen.x + 0.5) * width), round(height / 2 + seen.y * width))
        cv2.circle(image, at, max(1, round(seen.radius * width)), SEEN_COLOUR, 2)
    return bytes(cv2.imencode(".jpg", image)[1])
