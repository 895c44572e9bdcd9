"""A picture of a compass calibration: an SVG file, which every browser shows."""

import math
from html import escape
from pathlib import Path

from msgspec import Struct

from lbr import disk

Points = list[tuple[float, float]]
SIZE, MARGIN = 700, 60
"""The side of the square and its margin, in pixels."""
MOST_DRAWN = 2000
"""The most points of each kind: more could not be distinguished."""
STEPS_UT = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)
"""The possible distances between two lines of the grid."""
LINES = 6
"""The most lines on each side of the middle."""


class Drawing(Struct, frozen=True, kw_only=True):
    """Level parts of the magnetic field in microtesla, as measured and corrected; `corrected` may be empty."""

    title: str
    measured: Points
    corrected: Points


def save(drawing: Drawing, path: Path) -> None:
    """Write the file atomically."""
    with disk.replacing(path) as draft:
        draft.write_text(svg(drawing), encoding="utf-8")


def svg(drawing: Drawing) -> str:
    """Return the picture: both kinds of points about the middle, with the same scale on both axes."""
    kinds = (("measured", "#e07b00", drawing.measured), ("corrected", "#1f77b4", drawing.corrected))
    points = [point for _, _, of_kind in kinds for point in of_kind if all(map(math.isfinite, point))]
    most = max((abs(one) for point in points for one in point), default=1.0)
    step = next((one for one in STEPS_UT if LINES * one >= most), most / LINES)
    count = max(1, math.ceil(most / step))
    scale = (SIZE / 2 - MARGIN) / (count * step)

    def place(x: float, y: float) -> tuple[float, float]:
        return round(SIZE / 2 + x * scale, 1), round(SIZE / 2 - y * scale, 1)

    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIZE} {SIZE}" font-family="sans-serif" font-size="13">',
        f"<title>{escape(drawing.title)}</title>",
        '<rect width="100%" height="100%" fill="white"/>',
        f'<text x="{SIZE / 2}" y="24" text-anchor="middle">{escape(drawing.title)}</text>',
    ]
    for number in range(-count, count + 1):
        (at, low), (_, high) = place(number * step, -count * step), place(0.0, count * step)
        stroke = "#888" if number == 0 else "#ddd"
        parts.append(f'<path d="M{at} {low}V{high}M{high} {SIZE - at}H{low}" stroke="{stroke}"/>')
        parts.append(f'<text x="{at}" y="{low + 18}" text-anchor="middle" fill="#555">{number * step:g}</text>')
        parts.append(
            f'<text x="{MARGIN - 8}" y="{SIZE - at + 4}" text-anchor="end" fill="#555">{number * step:g}</text>'
        )
    parts.append(f'<text x="{SIZE / 2}" y="{SIZE - 12}" text-anchor="middle">level field, x (µT)</text>')
    parts.append(
        f'<text transform="translate(18 {SIZE / 2}) rotate(-90)" text-anchor="middle">level field, y (µT)</text>'
    )
    for row, (kind, colour, of_kind) in enumerate(kinds):
        finite = [point for point in of_kind if all(map(math.isfinite, point))]
        every = max(1, math.ceil(len(finite) / MOST_DRAWN))
        dots = "".join(f'<circle cx="{x}" cy="{y}" r="2"/>' for x, y in (place(*point) for point in finite[::every]))
        if dots:
            parts.append(f'<g fill="{colour}" fill-opacity="0.7">{dots}</g>')
            parts.append(
                f'<text x="{SIZE - MARGIN}" y="{48 + 18 * row}" text-anchor="end" fill="{colour}">● {kind}</text>'
            )
    return "\n".join([*parts, "</svg>\n"])
