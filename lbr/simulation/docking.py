"""The charging dock: when the robot's contacts touch it, and which of its beams the robot's receiver sees."""

from math import atan2, cos, degrees, hypot, pi, remainder, sin, tau
from types import ModuleType

import numpy as np

from lbr.simulation.bindings import MjData, MjModel
from lbr.simulation.measured import Beam
from lbr.simulation.messages import WorldDock
from lbr.simulation.model import STANDING
from lbr.simulation.settings import Body, Dock

Place = tuple[float, float, float]
"""x, y and yaw."""

_RECEIVER_Z_M = 0.22
_EMITTER_BEHIND_M = 0.05
_WINDOW_M = 0.005


class DockSense:
    """The dock's signals at a robot; both sensors are at its back."""

    def __init__(self, mujoco: ModuleType, model: MjModel, dock: Dock, body: Body) -> None:
        self._mujoco, self._model = mujoco, model
        self._dock = dock
        self._back_m = body.length_m / 2
        self._groups = np.array([group == STANDING for group in range(6)], dtype=np.uint8)

    def charging(self, robot: Place) -> bool:
        """Return whether both contacts touch their plates."""
        half = self._dock.contacts_m / 2
        return all(self._touches(robot, aside) for aside in (-half, half))

    def beams(self, data: MjData, robot: Place) -> frozenset[Beam]:
        """Return the beams that reach the receiver; `power` is seen only where the contacts touch."""
        seen: set[Beam] = {"power"} if self.charging(robot) else set()
        dock = self._dock
        x, y = _into(robot, (-self._back_m, 0.0))
        emitter = _into((dock.x_m, dock.y_m, dock.yaw_rad), (-_EMITTER_BEHIND_M, 0.0))
        ahead, aside = _from((*emitter, dock.yaw_rad), (x, y))
        bearing, far_m = degrees(atan2(aside, ahead)), hypot(ahead, aside)
        away = degrees(remainder(atan2(emitter[1] - y, emitter[0] - x) - robot[2] - pi, tau))
        if far_m > dock.reach_m or abs(away) > dock.receiver_deg / 2:
            return frozenset(seen)
        if -dock.overlap_deg / 2 <= bearing <= dock.spread_deg:
            seen.add("left")
        if -dock.spread_deg <= bearing <= dock.overlap_deg / 2:
            seen.add("right")
        return frozenset(seen) if not seen or self._in_sight(data, (x, y)) else frozenset(seen & {"power"})

    def _touches(self, robot: Place, aside_m: float) -> bool:
        dock = self._dock
        x, y = _into(robot, (-self._back_m, aside_m))
        gap_m, off_m = _from((dock.x_m, dock.y_m, dock.yaw_rad), (x, y))
        return abs(gap_m) <= dock.give_m and abs(off_m - aside_m) <= dock.plate_m

    def _in_sight(self, data: MjData, receiver: tuple[float, float]) -> bool:
        dock = self._dock
        x, y = _into((dock.x_m, dock.y_m, dock.yaw_rad), (_WINDOW_M, 0.0))
        start, end = np.array([*receiver, _RECEIVER_Z_M]), np.array([x, y, dock.height_m])
        way = end - start
        hit = np.full(1, -1, dtype=np.int32)
        share = self._mujoco.mj_ray(self._model, data, start, way, self._groups, 1, -1, hit, None)
        return bool(share < 0.0 or share >= 1.0)


def world_dock(dock: Dock) -> WorldDock:
    """Return the dock as a view needs it."""
    return WorldDock(
        x_m=dock.x_m,
        y_m=dock.y_m,
        yaw_rad=dock.yaw_rad,
        depth_m=dock.depth_m,
        width_m=dock.width_m,
        reach_m=dock.reach_m,
        spread_rad=dock.spread_deg * tau / 360,
        overlap_rad=dock.overlap_deg * tau / 360,
    )


def _into(place: Place, point: tuple[float, float]) -> tuple[float, float]:
    """Return the world's coordinates of a point relative to a place."""
    x, y, yaw = place
    return x + point[0] * cos(yaw) - point[1] * sin(yaw), y + point[0] * sin(yaw) + point[1] * cos(yaw)


def _from(place: Place, point: tuple[float, float]) -> tuple[float, float]:
    """Return the coordinates of a point of the world relative to a place."""
    x, y, yaw = place
    dx, dy = point[0] - x, point[1] - y
    return dx * cos(yaw) + dy * sin(yaw), dy * cos(yaw) - dx * sin(yaw)
