"""Draws a calibration, in a process of its own: `python -m lbr.operations.attitude.picture FILE.png < JSON`.

Importing matplotlib takes seconds. Exit code 3: it is not installed.
"""

import importlib
import os
import sys
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

NOT_INSTALLED = 3

Points = list[tuple[float, float]]


class Drawing(Struct, frozen=True, kw_only=True):
    """Level parts of the magnetic field in microtesla, as measured and corrected; `corrected` may be empty."""

    title: str
    measured: Points
    corrected: Points


def draw(drawing: Drawing, path: Path) -> None:
    """Write a PNG file; it is there whole or not at all."""
    matplotlib: Any = importlib.import_module("matplotlib")
    matplotlib.use("Agg")
    pyplot: Any = importlib.import_module("matplotlib.pyplot")
    figure, axes = pyplot.subplots(figsize=(7, 7), layout="constrained")
    for label, points, colour in (("measured", drawing.measured, "C1"), ("corrected", drawing.corrected, "C0")):
        if points:
            axes.scatter([x for x, _ in points], [y for _, y in points], s=6, c=colour, label=label)
    axes.plot(0.0, 0.0, "+", color="black", markersize=12)
    axes.set(aspect="equal", xlabel="level field, x (uT)", ylabel="level field, y (uT)", title=drawing.title)
    axes.grid(visible=True, alpha=0.3)
    axes.legend(loc="upper right")
    unfinished = path.with_suffix(".part")
    figure.savefig(unfinished, format="png", dpi=100)
    unfinished.replace(path)


def main() -> None:
    """Draw what standard input says."""
    os.nice(10)
    drawing = msgspec.json.decode(sys.stdin.buffer.read(), type=Drawing)
    try:
        draw(drawing, Path(sys.argv[1]))
    except ModuleNotFoundError as err:
        sys.stderr.write(f"{err}\n")
        sys.exit(NOT_INSTALLED)


if __name__ == "__main__":
    main()
