"""The physics of the simulated world: a differential-drive robot among boxes, its ranges, currents and battery."""

import importlib
import os
from math import atan2, cos, isfinite, pi, sin
from typing import Any

import numpy as np

from lbr.errors import LbrError
from lbr.messages.simulation import WorldBox, WorldPose, WorldScene
from lbr.simulation.battery import BatteryState
from lbr.simulation.measured import ImuReading, Sensed
from lbr.simulation.model import MAX_TORQUE_NM, TIMESTEP_S, model_xml
from lbr.simulation.plan import CONE_RAD
from lbr.simulation.settings import WorldSettings

os.environ.pop("MUJOCO_GL", None)  # the choice of a renderer that is not installed would fail the import
try:
    mujoco: Any = importlib.import_module("mujoco")  # its bindings carry no types
except ImportError as err:
    raise LbrError(f"the simulated world needs MuJoCo ({err}); install lbr with its extra 'sim'") from err

REACH_M = 7.65
"""What an MB1220 reports at most."""

_SENSE_EVERY = 10
_HEIGHT_M = 0.30
_RAYS = 15
_AMPS_PER_NM = 3.0
_AMPS_SETTLE = 0.15
_DIRECTIONS: tuple[tuple[str, float], ...] = (("forward", 0.0), ("left", pi / 2), ("right", -pi / 2), ("back", pi))


class Engine:
    """The world, moved by the power of its two wheels; the same steps with the same seed give the same run."""

    def __init__(self, settings: WorldSettings) -> None:
        self.settings = settings
        self.battery = BatteryState(settings.battery)
        self._model = mujoco.MjModel.from_xml_string(model_xml(settings))
        self._data = mujoco.MjData(self._model)
        self._random = np.random.default_rng(settings.seed)
        self._ranges: dict[str, float | None] = {}
        self._amps = self._drawn = (0.0, 0.0)
        self._power = (0.0, 0.0)
        self._owed_s = 0.0
        self._steps = 0
        self._groups = np.array([0, 1, 0, 0, 0, 0], dtype=np.uint8)
        self._walls = frozenset(index for index in range(self._model.ngeom) if self._model.geom_group[index] == 1)
        self._robot = frozenset(index for index in range(self._model.ngeom) if self._model.geom_group[index] == 2)
        self._wheels = [self._model.joint(name) for name in ("left", "right")]
        mujoco.mj_forward(self._model, self._data)
        self._sense()

    @property
    def time_s(self) -> float:
        """Seconds the world has run."""
        return float(self._data.time)

    def step(self, left: float, right: float, dt_s: float) -> None:
        """Run the world for `dt_s` with the wheels at a fraction of full power, forward positive."""
        self._power = (_limited(left), _limited(right))
        self._owed_s += dt_s
        while self._owed_s >= TIMESTEP_S - 1e-9:
            self._owed_s -= TIMESTEP_S
            self._step_once()

    def sensed(self) -> Sensed:
        """Return what devices can measure now."""
        per_turn = self.settings.body.counts_per_turn
        turns = [float(self._data.qpos[wheel.qposadr[0]]) / (2 * pi) for wheel in self._wheels]
        speeds = [float(self._data.qvel[wheel.dofadr[0]]) * 30 / pi for wheel in self._wheels]
        return Sensed(
            battery_v=self.battery.voltage_v,
            amps_a=self._amps,
            battery_amps_a=self._drawn,
            counts=(int(turns[0] * per_turn), int(turns[1] * per_turn)),
            speeds_rpm=(speeds[0], speeds[1]),
            ranges_m=dict(self._ranges),
        )

    def imu(self) -> ImuReading:
        """Return what an inertial unit measures at the newest step of the physics; cheap, for a twin that is read."""
        return ImuReading()

    def pose(self) -> WorldPose:
        """Return the truth about the robot."""
        x, y, yaw = self._place()
        ahead, leftward, turn = (float(self._data.qvel[index]) for index in (0, 1, 5))
        return WorldPose(
            x_m=x,
            y_m=y,
            yaw_rad=yaw,
            speed_mps=ahead * cos(yaw) + leftward * sin(yaw),
            turn_rps=turn,
            left=self._power[0],
            right=self._power[1],
            touching=self.touching(),
            battery_v=self.battery.voltage_v,
            time_s=self.time_s,
        )

    def scene(self) -> WorldScene:
        """Return what does not move, and the robot's outline."""
        walls = (
            WorldBox(name=b.name, x_m=b.x_m, y_m=b.y_m, length_m=b.length_m, width_m=b.width_m, yaw_rad=b.yaw_rad)
            for b in self.settings.walls
        )
        body = self.settings.body
        return WorldScene(walls=tuple(walls), robot_length_m=body.length_m, robot_width_m=body.width_m)

    def touching(self) -> bool:
        """Say whether the robot touches something that stands in the room."""
        data = self._data
        pairs = (data.contact.geom[index] for index in range(data.ncon))
        return any((a in self._walls and b in self._robot) or (b in self._walls and a in self._robot) for a, b in pairs)

    def _place(self) -> tuple[float, float, float]:
        x, y, _, qw, qx, qy, qz = (float(value) for value in self._data.qpos[:7])
        return x, y, atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))

    def _step_once(self) -> None:
        for index, power in enumerate(self._power):
            self._data.ctrl[index] = self._ramped(float(self._data.ctrl[index]), power)
        mujoco.mj_step(self._model, self._data)
        self._load()
        self._steps += 1
        if self._steps % _SENSE_EVERY == 0:
            self._sense()

    def _ramped(self, now_radps: float, power: float) -> float:
        """Return the wheel speed asked for next: motors speed up and slow down at what the drive can do."""
        body = self.settings.body
        radius = body.wheel_diameter_m / 2
        wanted = power * body.max_speed_mps / radius
        slowing = abs(wanted) < abs(now_radps) or wanted * now_radps < 0
        most = (body.deceleration_mps2 if slowing else body.acceleration_mps2) / radius * TIMESTEP_S
        return now_radps + max(-most, min(most, wanted - now_radps))

    def _load(self) -> None:
        """Update motor and battery currents from the torques."""
        left, right = (
            amps + (float(torque) * _AMPS_PER_NM - amps) * _AMPS_SETTLE
            for amps, torque in zip(self._amps, self._data.actuator_force, strict=True)
        )
        duties = self._duties()
        self._amps = (left, right)
        self._drawn = (left * duties[0], right * duties[1])
        self.battery.draw(sum(self._drawn), TIMESTEP_S)

    def _duties(self) -> tuple[float, float]:
        """Return how far the bridges are open: as the wheels turn, and more as they are held."""
        full = self.settings.body.max_speed_mps / (self.settings.body.wheel_diameter_m / 2)
        left, right = (
            max(-1.0, min(1.0, float(self._data.qvel[wheel.dofadr[0]]) / full + float(torque) / (2 * MAX_TORQUE_NM)))
            for wheel, torque in zip(self._wheels, self._data.actuator_force, strict=True)
        )
        return (left, right)

    def _sense(self) -> None:
        """Let each sensor look along its cone, in turn; noise is drawn whether or not anybody listens."""
        body = self.settings.body
        x, y, yaw = self._place()
        for side, angle in _DIRECTIONS:
            offset = (body.length_m if side in {"forward", "back"} else body.width_m) / 2
            heading = yaw + angle
            origin = np.array([x + offset * cos(heading), y + offset * sin(heading), _HEIGHT_M])
            nearest = self._nearest(origin, heading)
            noise = float(self._random.normal(0.0, self.settings.range_noise_m))
            self._ranges[side] = None if nearest is None else max(0.0, nearest + noise)

    def _nearest(self, origin: "np.ndarray[tuple[int], np.dtype[np.float64]]", heading: float) -> float | None:
        angles = heading + np.linspace(-CONE_RAD, CONE_RAD, _RAYS)
        rays = np.stack([np.cos(angles), np.sin(angles), np.zeros(_RAYS)], axis=1).ravel()
        hit, distance = np.full(_RAYS, -1, dtype=np.int32), np.full(_RAYS, -1.0)
        mujoco.mj_multiRay(
            self._model, self._data, origin, rays, self._groups, 1, -1, hit, distance, None, _RAYS, REACH_M
        )
        seen = distance[hit >= 0]
        return float(seen.min()) if seen.size else None


def _limited(power: float) -> float:
    return max(-1.0, min(1.0, power)) if isfinite(power) else 0.0
