"""The check of `lbr doctor` for a robot in ROS 2: whether the router of ROS answers."""

import socket
from collections.abc import Iterable, Iterator

from lbr import home
from lbr.apps.ros2.kind import KIND, Ros2Settings, address
from lbr.commands.finding import Finding
from lbr.database.rows import CapabilityRow
from lbr.messages.unreadable import UNREADABLE

PATIENCE_S = 1.0
START = "ros2 run rmw_zenoh_cpp rmw_zenohd, or set 'listen' of the row: docs/ros2.md"


def router(robot: str, rows: Iterable[CapabilityRow]) -> Iterator[Finding]:
    """Check the router of every bridge of a robot to ROS."""
    runs = any(one.robot == robot for one in home.running())
    for row in rows:
        if row.kind == KIND.name and row.enabled:
            about = f"ROS 2 by '{row.name}'"
            try:
                settings = KIND.parse(row.settings)
            except UNREADABLE as err:
                yield Finding(about=about, level="bad", text=f"the row's settings: {err}", do="lbr db check")
            else:
                assert isinstance(settings, Ros2Settings)
                yield _router(about, settings, runs=runs)


def _router(about: str, settings: Ros2Settings, *, runs: bool) -> Finding:
    endpoint = settings.listen or settings.connect
    try:
        socket.create_connection(address(endpoint), PATIENCE_S).close()
    except OSError as err:
        if settings.listen and not runs:
            return Finding(about=about, level="good", text=f"nobody has {endpoint}, where the robot will be its router")
        text = f"no router of ROS answers at {endpoint}: {err.strerror or err}"
        return Finding(about=about, level="hint", text=text, do="lbr status" if settings.listen else START)
    if settings.listen and not runs:
        text = f"another program has {endpoint}, where the robot is to be the router of ROS"
        return Finding(about=about, level="hint", text=text, do="stop it, or set 'connect' of the row instead")
    return Finding(about=about, level="good", text=f"a router of ROS answers at {endpoint}")
