"""Cameras, numbers and the path of a robot in a notebook, drawn live in one place of its output.

    from lbr.client import notebook           # in the distribution lbr-client: from lbr_client import notebook

    with client.connect() as robot, robot.drive(0.1, at_most_s=10):
        notebook.show(robot, "camera_front", for_s=3)     # the newest picture, as they come
        notebook.plot(robot, "drive/state.power", for_s=5)
        notebook.way(robot, for_s=5)                      # its path by odometry

They need the packages of the extra `jupyter`: IPython and matplotlib.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import closing
from io import BytesIO
from math import cos, sin
from typing import Any

from IPython.display import DisplayHandle, Image, display
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lbr.client.robot import Robot
from lbr.errors import InputError

DRAW_S = 0.2
SIZE_IN = (6.0, 3.5)
ARROW_M = 0.15

Number = float | None


def show(robot: Robot, camera: str = "camera_front", *, for_s: float = 10.0) -> None:
    """Show a camera's pictures as they come."""
    place: DisplayHandle | None = None
    with closing(robot.pictures(camera)) as pictures:
        for picture in _until_over(pictures, for_s):
            place = _drawn(place, Image(data=bytes(picture), format="jpeg"))  # type: ignore[no-untyped-call]


def plot(robot: Robot, *fields: str, for_s: float = 10.0) -> dict[str, list[tuple[float, Number]]]:
    """Plot numbers such as `drive/state.power` over time; return their samples: seconds since the start, value."""
    if not fields:
        raise InputError("name what is to be plotted, such as 'drive/state.power'")
    samples: dict[str, list[tuple[float, Number]]] = {field: [] for field in fields}
    began = time.monotonic()

    def look() -> None:
        for field, values in samples.items():
            values.append((time.monotonic() - began, _number(robot, field)))

    def draw(axes: Axes) -> None:
        for field, values in samples.items():
            axes.plot([t for t, _ in values], [_nan(value) for _, value in values], label=field)
        axes.set_xlabel("s")
        axes.legend(loc="upper left")

    _live(look, draw, for_s)
    return samples


def way(robot: Robot, *, for_s: float = 10.0, pose: str = "odometry/state") -> list[tuple[float, float, float]]:
    """Draw the path by odometry, with an arrow ahead; return its poses: x and y in metres, yaw in radians."""
    poses: list[tuple[float, float, float]] = []

    def look() -> None:
        state = robot.latest(pose)
        if state["valid"]:
            poses.append((state["x_m"], state["y_m"], state["yaw_rad"]))

    def draw(axes: Axes) -> None:
        axes.plot([x for x, _, _ in poses], [y for _, y, _ in poses])
        for x, y, yaw in poses[-1:]:
            axes.arrow(x, y, ARROW_M * cos(yaw), ARROW_M * sin(yaw), width=ARROW_M / 5)
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel("x, m")
        axes.set_ylabel("y, m")

    _live(look, draw, for_s)
    return poses


def _live(look: Callable[[], None], draw: Callable[[Axes], None], for_s: float) -> None:
    place: DisplayHandle | None = None
    for _ in _until_over(_ticks(), for_s):
        look()
        figure = Figure(figsize=SIZE_IN, layout="constrained")
        draw(figure.add_subplot())
        place = _drawn(place, _png(figure))


def _png(figure: Figure) -> Image:
    """Draw a figure here, whatever the notebook's own backend."""
    drawn = BytesIO()
    figure.savefig(drawn, format="png")
    return Image(data=drawn.getvalue(), format="png")  # type: ignore[no-untyped-call]


def _drawn(place: DisplayHandle | None, content: object) -> DisplayHandle | None:
    if place is not None:
        place.update(content)  # type: ignore[no-untyped-call]
        return place
    shown: DisplayHandle | None = display(content, display_id=True)  # type: ignore[no-untyped-call]
    return shown


def _ticks() -> Iterator[None]:
    while True:
        yield
        time.sleep(DRAW_S)


def _until_over(found: Iterator[object], for_s: float) -> Iterator[Any]:
    until = time.monotonic() + for_s
    for one in found:
        yield one
        if time.monotonic() >= until:
            return


def _number(robot: Robot, field: str) -> Number:
    name, _, path = field.partition(".")
    value: Any = robot.latest(name)
    for part in path.split("."):
        value = value.get(part) if isinstance(value, dict) else None
    if isinstance(value, bool | int | float) or value is None:
        return None if value is None else float(value)
    raise InputError(f"'{field}' is no number; name a field such as 'drive/state.power'")


def _nan(value: Number) -> float:
    return float("nan") if value is None else value
