"""Detection by OpenCV: decodes pictures, detects the target in them, and marks it."""

from collections.abc import Callable
from math import pi
from typing import NamedTuple, Protocol

import cv2
import numpy as np
from cv2.typing import MatLike

from lbr.apps.vision.settings import MODEL_HINT, VisionSettings
from lbr.bus import pictures
from lbr.errors import InputError
from lbr.messages.tracking import Seen, Target

Image = MatLike

MOST_PIXELS = 4096 * 4096
REDUCED_TO_PX = 320
"""The least width of a decoded picture. Pictures are decoded at a half, a quarter or an eighth of their size."""
LEAST_RADIUS = 0.006
"""The least radius of a blob as a share of the picture's width, 4 pixels of 640. Smaller ones are noise."""
LEAST_ROUND = 0.55
"""The least share of its enclosing circle that a round blob covers. A ball half in shade is round, a stripe not."""
FACE_SCORE = 0.7
MIDDLE = 0.04
"""Half the side of the middle square, as a share of the width. The sample colour should fill the square."""
USUAL_PERCENT = (5.0, 95.0)
SEEN_COLOUR, MIDDLE_COLOUR = (0, 255, 0), (255, 255, 255)


class Hsv(NamedTuple):
    """A colour on OpenCV's scales: hue 0 to 180, saturation and value 0 to 255."""

    hue: float
    saturation: float
    value: float


class Detector(Protocol):
    """The methods of OpenCV's face detector that are called here."""

    def setInputSize(self, input_size: tuple[int, int]) -> None:  # noqa: N802 - the library's name
        """Set the size of the next picture."""

    def detect(self, image: Image) -> tuple[int, Image | None]:
        """Return a row for each face: left, top, width and height in pixels, ten landmarks, and the score."""


def finder(settings: VisionSettings, target: Target) -> Callable[[bytes], Seen | None]:
    """Return a detector of the target in JPEG pictures; raise InputError if OpenCV cannot read the model."""
    cv2.setNumThreads(1)
    if target == "face":
        faces = _face_detector(settings.face_model)
        return lambda data: _in(data, lambda image: largest_face(image, faces))
    ranges = hsv_ranges(settings)
    return lambda data: _in(data, lambda image: largest_round(mask(image, ranges)))


def decode(data: bytes) -> Image | None:
    """Return a JPEG picture as a small BGR image; None for other data, or an implausible size."""
    size = pictures.size_px(data)
    if size is None or not 0 < size[0] * size[1] <= MOST_PIXELS:
        return None
    flags = {1: cv2.IMREAD_COLOR, 2: cv2.IMREAD_REDUCED_COLOR_2, 4: cv2.IMREAD_REDUCED_COLOR_4}
    try:
        flag = flags.get(reduction(size[0]), cv2.IMREAD_REDUCED_COLOR_8)
        image = cv2.imdecode(np.frombuffer(data, np.uint8), flag)
    except cv2.error:
        return None
    return image


def reduction(width_px: int) -> int:
    """Return the divisor for a picture of this width: 1, 2, 4 or 8."""
    return next((by for by in (8, 4, 2) if width_px // by >= REDUCED_TO_PX), 1)


def hsv_ranges(settings: VisionSettings) -> tuple[tuple[Hsv, Hsv], ...]:
    """Return the colour of the settings as ranges from low to high; a hue across red, such as 350 to 10, has two."""
    low, high = (degrees / 2.0 for degrees in settings.hue_deg)
    saturations = [percent * 2.55 for percent in settings.saturation_percent]
    values = [percent * 2.55 for percent in settings.value_percent]
    hues = [(low, high)] if low <= high else [(low, 180.0), (0.0, high)]
    return tuple((Hsv(a, saturations[0], values[0]), Hsv(b, saturations[1], values[1])) for a, b in hues)


def mask(image: Image, ranges: tuple[tuple[Hsv, Hsv], ...]) -> Image:
    """Return a mask without specks: 255 where the picture has the colour, else 0."""
    hsv = cv2.cvtColor(cv2.blur(image, (3, 3)), cv2.COLOR_BGR2HSV)
    masks = [cv2.inRange(hsv, np.floor(low), np.ceil(high)) for low, high in ranges]
    whole = masks[0] if len(masks) == 1 else cv2.bitwise_or(masks[0], masks[1])
    return cv2.morphologyEx(whole, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))


def largest_round(colour_mask: Image) -> Seen | None:
    """Return the largest roughly round blob; at the picture's edge only the visible part must be round."""
    height, width = colour_mask.shape[:2]
    contours, _ = cv2.findContours(colour_mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    best, best_area = None, 0.0
    for contour in contours:
        (x, y), radius = cv2.minEnclosingCircle(contour)
        area = cv2.contourArea(contour) + len(contour) / 2.0  # the contour runs through the middles of its pixels
        cut = not (radius <= x <= width - 1 - radius and radius <= y <= height - 1 - radius)
        round_enough = area >= LEAST_ROUND * pi * radius**2 * (0.5 if cut else 1.0)
        if area > best_area and radius >= LEAST_RADIUS * width and round_enough:
            best, best_area = (x, y, radius + 0.5), area
    return _seen(*best, width, height) if best is not None else None


def largest_face(image: Image, detector: Detector) -> Seen | None:
    """Return the largest face."""
    height, width = image.shape[:2]
    detector.setInputSize((width, height))
    _, faces = detector.detect(image)
    if faces is None or len(faces) == 0:
        return None
    left, top, wide, high = (float(value) for value in max(faces, key=lambda face: face[2] * face[3])[:4])
    return _seen(left + wide / 2.0, top + high / 2.0, max(wide, high) / 2.0, width, height)


def _seen(x: float, y: float, radius: float, width: int, height: int) -> Seen | None:
    values = ((x + 0.5) / width - 0.5, ((y + 0.5) - height / 2.0) / width, radius / width)
    within = all(-1.0 <= value <= 1.0 for value in values)  # false for NaN
    return Seen(x=values[0], y=values[1], radius=values[2]) if within and radius >= 0.0 else None


def _in(data: bytes, look: Callable[[Image], Seen | None]) -> Seen | None:
    image = decode(data)
    if image is None:
        return None
    try:
        return look(image)
    except cv2.error as err:
        raise InputError(f"OpenCV gave up on a picture of {image.shape[1]}x{image.shape[0]}: {err.err or err}") from err


def _face_detector(model: str) -> Detector:
    """Return the detector; raise InputError if OpenCV cannot read the model."""
    try:
        detector: Detector = cv2.FaceDetectorYN.create(model, "", (REDUCED_TO_PX, REDUCED_TO_PX), FACE_SCORE)
    except cv2.error as err:
        raise InputError(f"{model} is not a model of a YuNet face detector; {MODEL_HINT}") from err
    return detector


def middle(image: Image) -> str:
    """Return the colours of the middle in words. Hues wrap, so they are measured from the most frequent one."""
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


def marked(image: Image, seen: Seen | None) -> bytes:
    """Return the picture as JPEG, with its middle and the target marked."""
    height, width = image.shape[:2]
    middle, half = (width // 2, height // 2), max(1, round(MIDDLE * width))
    corners = [(middle[0] + side * half, middle[1] + side * half) for side in (-1, 1)]
    cv2.rectangle(image, corners[0], corners[1], MIDDLE_COLOUR, 1)
    if seen is not None:
        at = (round((seen.x + 0.5) * width), round(height / 2 + seen.y * width))
        cv2.circle(image, at, max(1, round(seen.radius * width)), SEEN_COLOUR, 2)
    return bytes(cv2.imencode(".jpg", image)[1])
