"""Pictures with balls in them, as JPEG; needs OpenCV."""

import cv2
import numpy as np

ORANGE, GREY = (20, 110, 235), (120, 110, 100)
SEED = 7


def picture(*balls, width=640, height=480, noise=8.0, light=1.0, background=GREY, quality=85, more=None):
    """A JPEG picture with balls (x, y, radius, colour), all in pixels; a ball is lit from above and has a highlight."""
    image = np.full((height, width, 3), background, np.float32)
    rows, columns = np.mgrid[0:height, 0:width].astype(np.float32)
    for x, y, radius, colour in balls:
        away = np.hypot(columns - x, rows - y)
        lit = np.clip(0.85 - 0.35 * (rows - y) / radius, 0.4, 1.0)
        shine = np.hypot(columns - x + 0.3 * radius, rows - y + 0.4 * radius) < 0.12 * radius
        cover = np.clip(radius + 0.5 - away, 0.0, 1.0)[..., None]
        ball = np.where(shine[..., None], 255.0, lit[..., None] * np.array(colour, np.float32))
        image = image * (1.0 - cover) + ball * cover
    if more is not None:
        more(image)
    image = light * image + np.random.default_rng(SEED).normal(0.0, noise, image.shape)
    data = cv2.imencode(".jpg", image.clip(0, 255).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    return data.tobytes()
