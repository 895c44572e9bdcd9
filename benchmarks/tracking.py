"""The cost and precision of tracking for each picture, compared with decoding it and with another method.

`python -m benchmarks tracking --seconds 10`. Pictures of 640x480 with a ball, as JPEG, are made here: noisy, lit from
above, with a highlight. `blob` is the method of tracking; `circles` finds the same ball in the same mask by Hough's
transform. The last line is a process with 15 pictures a second, like tracking.
"""

import argparse
import statistics
import time
from collections.abc import Callable
from math import hypot

import cv2
import numpy as np
import psutil

from benchmarks import Measured
from lbr.apps.vision import finding, opencv
from lbr.apps.vision.eye import Eye
from lbr.apps.vision.tracking.kind import TrackingSettings
from lbr.messages.tracking import Seen

SMOKE = "--seconds 0.2 --pictures 4"

WIDTH, HEIGHT, FPS = 640, 480, 15
ORANGE, GREY = (20, 110, 235), (120, 110, 100)


def options(parser: argparse.ArgumentParser) -> None:
    """Add the duration."""
    parser.add_argument("--pictures", type=int, default=60, help="to find the ball in (default %(default)s)")
    parser.add_argument("--seconds", type=float, default=10.0, help="how long to look (default %(default)s)")


def measure(given: argparse.Namespace) -> Measured:
    """Find the ball in pictures made here."""
    made = pictures(given.pictures)
    settings = TrackingSettings()
    ranges = opencv.hsv_ranges(settings)
    blob = finding.finder(settings, "colour")
    kilobytes = statistics.mean(len(data) for data, _ in made) / 1000
    text = [
        f"OpenCV {cv2.__version__}, {WIDTH}x{HEIGHT}, {kilobytes:.0f} kB",
        f"{'decode, whole':24}{_ms(made, lambda data: cv2.imdecode(_bytes(data), cv2.IMREAD_COLOR)):8.2f} ms",
        f"{'decode, half':24}{_ms(made, opencv.decode):8.2f} ms",
    ]
    for name, find in (("blob", blob), ("circles", lambda data: _circles(data, ranges))):
        errors, missed = _errors(made, find)
        text.append(
            f"{'decode, half, ' + name:24}{_ms(made, find):8.2f} ms  middle {errors[0]:.2f} px, worst {errors[1]:.2f} px, "
            f"missed {missed} of {len(made)}"
        )
    text.append(_looked(blob, [data for data, _ in made], given.seconds))
    return Measured(text="\n".join(text))


def pictures(count: int) -> list[tuple[bytes, tuple[float, float, float]]]:
    """Return pictures with the place of the ball in each: x, y and radius in pixels."""
    dice = np.random.default_rng(7)
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH].astype(np.float32)
    made = []
    for _ in range(count):
        radius = float(dice.uniform(6.0, 80.0))
        x, y = float(dice.uniform(radius, WIDTH - radius)), float(dice.uniform(radius, HEIGHT - radius))
        lit = np.clip(0.85 - 0.35 * (rows - y) / radius, 0.4, 1.0)[..., None]
        shine = np.hypot(columns - x + 0.3 * radius, rows - y + 0.4 * radius) < 0.12 * radius
        cover = np.clip(radius + 0.5 - np.hypot(columns - x, rows - y), 0.0, 1.0)[..., None]
        ball = np.where(shine[..., None], 255.0, lit * np.array(ORANGE, np.float32))
        image = np.array(GREY, np.float32) * (1.0 - cover) + ball * cover + dice.normal(0.0, 8.0, (HEIGHT, WIDTH, 3))
        data = cv2.imencode(".jpg", image.clip(0, 255).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, 85])[1]
        made.append((data.tobytes(), (x, y, radius)))
    return made


def _circles(data: bytes, ranges: tuple[tuple[opencv.Hsv, opencv.Hsv], ...]) -> Seen | None:
    image = opencv.decode(data)
    assert image is not None
    where = cv2.GaussianBlur(opencv.mask(image, ranges), (5, 5), 0)
    found = cv2.HoughCircles(where, cv2.HOUGH_GRADIENT, 1, 40, param1=100, param2=10, minRadius=2, maxRadius=60)
    if found is None:
        return None
    x, y, radius = max(found[0], key=lambda circle: circle[2])
    height, width = where.shape
    return Seen(x=(x + 0.5) / width - 0.5, y=(y + 0.5 - height / 2) / width, radius=radius / width)


def _errors(
    made: list[tuple[bytes, tuple[float, float, float]]], find: finding.Finder
) -> tuple[tuple[float, float], int]:
    errors, missed = [], 0
    for data, (x, y, _) in made:
        seen = find(data)
        if seen is None:
            missed += 1
        else:
            errors.append(hypot((seen.x + 0.5) * WIDTH - 0.5 - x, seen.y * WIDTH + HEIGHT / 2 - 0.5 - y))
    return (statistics.mean(errors), max(errors)), missed


def _ms(made: list[tuple[bytes, tuple[float, float, float]]], work: Callable[[bytes], object]) -> float:
    times = []
    for _ in range(3):
        began = time.process_time()
        for data, _ in made:
            work(data)
        times.append((time.process_time() - began) / len(made) * 1000.0)
    return min(times)


def _looked(find: finding.Finder, made: list[bytes], seconds: float) -> str:
    process = psutil.Process()
    eye = Eye(lambda: find, lambda: None)
    began, cpu, due, count = time.monotonic(), time.process_time(), time.monotonic(), 0
    while time.monotonic() < began + seconds:
        eye.look(made[count % len(made)], due)
        count, due = count + 1, due + 1.0 / FPS
        time.sleep(max(0.0, due - time.monotonic()))
    share = (time.process_time() - cpu) / (time.monotonic() - began)
    eye.close()
    return f"{FPS} pictures/s: {share:.1%} of a core; {process.memory_info().rss / 2**20:.0f} MiB in use"


def _bytes(data: bytes) -> "np.ndarray[tuple[int], np.dtype[np.uint8]]":
    return np.frombuffer(data, np.uint8)
