"""Ultrasonic sensors: rays that fill a cone, the nearest of which comes back, if it comes back."""

from collections.abc import Sequence
from math import cos, erf, pi, radians, sin, sqrt, tau
from typing import Any

import numpy as np

from lbr.simulation.model import STANDING
from lbr.simulation.noise import Floats, Noise
from lbr.simulation.plan import CONE_RAD
from lbr.simulation.settings import Body, Ultrasonic

REACH_M = 7.65
"""What an MB1220 reports at most."""

SIDES: tuple[tuple[str, float], ...] = (("forward", 0.0), ("left", pi / 2), ("right", -pi / 2), ("back", pi))
"""Which way each sensor looks, anticlockwise from ahead."""

_FAN = 25
"""Rays side by side, and as many above each other: at 2 m no leg or table top of 4 cm slips through."""

_RINGS = ((0.5, 8), (1.0, 12))


class Ring:
    """The four sensors; `look` tells what each finds from where the robot is."""

    def __init__(self, mujoco: Any, model: Any, body: Body, settings: Ultrasonic, seed: int) -> None:
        self._mujoco, self._model = mujoco, model
        self._settings = settings
        self._offsets = {
            name: (body.length_m if name in {"forward", "back"} else body.width_m) / 2 for name, _ in SIDES
        }
        self._noise = {name: Noise(seed, f"range {name}", 2) for name, _ in SIDES}
        self._cone = _cone()
        self._groups = np.array([group == STANDING for group in range(6)], dtype=np.uint8)
        self._least_cos = cos(radians(settings.grazing_deg))
        count = len(self._cone)
        self._hit, self._distance = np.full(count, -1, dtype=np.int32), np.full(count, -1.0)
        self._normal = np.zeros(3 * count) if settings.grazing_deg < 90.0 else None

    def look(self, data: Any, place: tuple[float, float, float], step: int) -> dict[str, float | None]:
        """Return what each sensor finds in metres; null: nothing within its reach."""
        x, y, yaw = place
        found: dict[str, float | None] = {}
        for name, angle in SIDES:
            heading, offset = yaw + angle, self._offsets[name]
            origin = (x + offset * cos(heading), y + offset * sin(heading), self._settings.height_m)
            found[name] = self._heard(name, self._nearest(data, origin, heading), step)
        return found

    def _heard(self, name: str, nearest_m: float | None, step: int) -> float | None:
        settings = self._settings
        normal, chance = (float(value) for value in self._noise[name].at(step))
        if nearest_m is None or (settings.dropout > 0.0 and _uniform(chance) < settings.dropout):
            return None
        return max(0.0, nearest_m + normal * (settings.noise_m + settings.noise_per_m * nearest_m))

    def _nearest(self, data: Any, origin: Sequence[float], heading: float) -> float | None:
        c, s = cos(heading), sin(heading)
        rays = self._cone @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        self._mujoco.mj_multiRay(
            self._model, data, np.array(origin), rays.ravel(), self._groups, 1, -1,
            self._hit, self._distance, self._normal, len(rays), REACH_M,
        )  # fmt: skip
        heard = self._hit >= 0
        if self._normal is not None:
            heard &= np.abs(np.einsum("ij,ij->i", rays, self._normal.reshape(-1, 3))) >= self._least_cos
        seen = self._distance[heard]
        return float(seen.min()) if seen.size else None


def _cone() -> Floats:
    """Return rays around x: an upright cross, and rings between its arms."""
    fan = [float(share) for share in np.linspace(-1.0, 1.0, _FAN)]
    shares = [(share, 0.0) for share in fan] + [(0.0, share) for share in fan if share != 0.0]
    for radius, count in _RINGS:
        turns = ((step + 0.5) * tau / count for step in range(count))
        shares += [(radius * cos(turn), radius * sin(turn)) for turn in turns]
    angles = [(side * CONE_RAD, up * CONE_RAD) for side, up in shares]
    return np.array([(cos(side) * cos(up), sin(side) * cos(up), sin(up)) for side, up in angles])


def _uniform(normal: float) -> float:
    """Return how often a normal value is smaller: an even chance between 0 and 1."""
    return (1.0 + erf(normal / sqrt(2.0))) / 2.0
