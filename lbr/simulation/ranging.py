"""Sensors of distance in the world: rays that fill a cone, with the nearest echo, or rays all around, each by
itself."""

from collections.abc import Iterable
from math import ceil, cos, erf, radians, sin, sqrt, tau
from types import ModuleType
from typing import Any

import numpy as np

from lbr.messages.sensing import RangeSensor
from lbr.simulation.bindings import MjData, MjModel
from lbr.simulation.model import STANDING
from lbr.simulation.noise import Floats, Noise
from lbr.simulation.settings import Ultrasonic

REACH_M = 7.65
"""The greatest reading of an MB1220."""

_FAN_RAD = 0.4 / 24
"""Between rays, in both directions: at 2 m no leg or table top of 4 cm slips through."""

_RINGS = ((0.5, 8), (1.0, 12))


class Rangers:
    """The robot's level sensors of distance; `look` and `scan` return their distances from a place."""

    def __init__(
        self, mujoco: ModuleType, model: MjModel, sensors: Iterable[RangeSensor], settings: Ultrasonic, seed: int
    ) -> None:
        self._mujoco, self._model = mujoco, model
        self._settings = settings
        level = [sensor for sensor in sensors if sensor.level]
        self._singles = [sensor for sensor in level if sensor.rays == 1]
        self._scanners = [sensor for sensor in level if sensor.rays > 1]
        self._noise = {sensor.name: Noise(seed, f"range {sensor.name}", 2) for sensor in self._singles}
        self._rays = {sensor.name: _turned(_cone(sensor.fov_rad), sensor) for sensor in self._singles}
        self._rays |= {sensor.name: _turned(_fan(sensor), sensor) for sensor in self._scanners}
        self._groups = np.array([group == STANDING for group in range(6)], dtype=np.uint8)
        self._least_cos = cos(radians(settings.grazing_deg))
        self._faced: dict[str, float | None] = {}

    def look(self, data: MjData, place: tuple[float, float, float], step: int) -> dict[str, float | None]:
        """Return the distance of each single-distance sensor in metres; None: nothing within its reach."""
        self._faced = {sensor.name: self._nearest(data, place, sensor) for sensor in self._singles}
        return self.again(step)

    def again(self, step: int) -> dict[str, float | None]:
        """Return the same distances with new noise, without rays, while nothing has moved since the last look."""
        return {name: self._measured_m(name, nearest_m, step) for name, nearest_m in self._faced.items()}

    def scan(self, data: MjData, place: tuple[float, float, float]) -> dict[str, tuple[float | None, ...]]:
        """Return the distances of each scanner along its rays, in metres; None: nothing within its reach."""
        scans = {}
        for sensor in self._scanners:
            hit, distance, _, _ = self._cast(data, place, sensor, sensor.max_m)
            scans[sensor.name] = tuple(
                metres if geom >= 0 else None for geom, metres in zip(hit.tolist(), distance.tolist(), strict=True)
            )
        return scans

    def _measured_m(self, name: str, nearest_m: float | None, step: int) -> float | None:
        settings = self._settings
        normal, chance = (float(value) for value in self._noise[name].at(step))
        if nearest_m is None or (settings.dropout > 0.0 and _uniform(chance) < settings.dropout):
            return None
        return max(0.0, nearest_m + normal * (settings.noise_m + settings.noise_per_m * nearest_m))

    def _nearest(self, data: MjData, place: tuple[float, float, float], sensor: RangeSensor) -> float | None:
        ultrasonic = sensor.kind == "ultrasonic"
        hit, distance, normal, rays = self._cast(
            data, place, sensor, min(sensor.max_m, REACH_M) if ultrasonic else sensor.max_m
        )
        heard = hit >= 0
        if normal is not None and ultrasonic:
            heard &= np.abs(np.einsum("ij,ij->i", rays, normal.reshape(-1, 3))) >= self._least_cos
        seen = distance[heard]
        return float(seen.min()) if seen.size else None

    def _cast(
        self, data: MjData, place: tuple[float, float, float], sensor: RangeSensor, reach_m: float
    ) -> tuple[Any, Floats, Floats | None, Floats]:
        """Return the body that each ray of a sensor hits (-1: none) and its distance, with the normal if needed."""
        x, y, yaw = place
        c, s = cos(yaw), sin(yaw)
        height_m = self._settings.height_m if self._settings.height_m is not None else sensor.z_m
        origin = np.array((x + sensor.x_m * c - sensor.y_m * s, y + sensor.x_m * s + sensor.y_m * c, height_m))
        rays = self._rays[sensor.name] @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        hit, distance = np.full(len(rays), -1, dtype=np.int32), np.full(len(rays), -1.0)
        normal = np.zeros(3 * len(rays)) if self._settings.grazing_deg < 90.0 and sensor.rays == 1 else None
        self._mujoco.mj_multiRay(
            self._model, data, origin, rays.ravel(), self._groups, 1, -1, hit, distance, normal, len(rays), reach_m,
        )  # fmt: skip
        return hit, distance, normal, rays


def _cone(fov_rad: float) -> Floats:
    """Return rays around x: an upright cross, and rings between its arms."""
    half = fov_rad / 2
    fan = [float(share) for share in np.linspace(-1.0, 1.0, 2 * max(2, ceil(half / _FAN_RAD - 1e-9)) + 1)]
    shares = [(share, 0.0) for share in fan] + [(0.0, share) for share in fan if share != 0.0]
    for radius, count in _RINGS:
        turns = ((step + 0.5) * tau / count for step in range(count))
        shares += [(radius * cos(turn), radius * sin(turn)) for turn in turns]
    angles = [(side * half, up * half) for side, up in shares]
    return np.array([(cos(side) * cos(up), sin(side) * cos(up), sin(up)) for side, up in angles])


def _fan(sensor: RangeSensor) -> Floats:
    """Return the rays of a scan, in a plane, with the first one to the right."""
    return np.array([(cos(angle), sin(angle), 0.0) for angle in sensor.angles()])


def _turned(rays: Floats, sensor: RangeSensor) -> Floats:
    """Return rays around x, turned as the sensor is on the robot: yaw, then pitch, downwards positive."""
    cp, sp, cy, sy = cos(sensor.pitch_rad), sin(sensor.pitch_rad), cos(sensor.yaw_rad), sin(sensor.yaw_rad)
    pitched = rays @ np.array([[cp, 0.0, -sp], [0.0, 1.0, 0.0], [sp, 0.0, cp]])
    turned: Floats = pitched @ np.array([[cy, sy, 0.0], [-sy, cy, 0.0], [0.0, 0.0, 1.0]])
    return turned


def _uniform(normal: float) -> float:
    """Return the probability that a normal value is smaller: uniform between 0 and 1."""
    return (1.0 + erf(normal / sqrt(2.0))) / 2.0
