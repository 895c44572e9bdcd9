"""The physics of the simulated world: a robot on wheels among furniture, and the measurements of its devices."""

from collections.abc import Callable, Mapping, Sequence
from math import atan2, cos, hypot, isfinite, pi, sin
from typing import Any

import msgspec
import numpy as np
from msgspec.structs import replace

from lbr.messages.kinematics import HOLONOMIC, TWO, Kinematics, Wheel
from lbr.messages.sensing import RangeSensor, ring
from lbr.simulation.docking import DockSense, world_dock
from lbr.simulation.measured import Beam, MotorSensed, Sensed
from lbr.simulation.messages import WorldBox, WorldPose, WorldScene, WorldSensor
from lbr.simulation.model import DOCK, MAX_TORQUE_NM, ROBOT, STANDING, TIMESTEP_S, model_xml, two_wheels
from lbr.simulation.physics import mujoco
from lbr.simulation.placing import Placed
from lbr.simulation.ranging import Rangers
from lbr.simulation.rollers import Rollers
from lbr.simulation.room import BoxSettings
from lbr.simulation.settings import WorldSettings
from lbr.simulation.stepped import SteppedEngine

_SENSE_EVERY = 10
_SETTLING_STEPS = 100
_STILL, _STILL_STEPS = 1e-6, 125
"""A body that moves slower than this, in m/s or rad/s, for so many steps without power, stands."""

_AMPS_PER_NM = 3.0
_AMPS_SETTLE = 0.15


class Engine(SteppedEngine):
    """The world, moved by the power of its motors; the same steps with the same seed give the same run.

    `sensors` are the robot's sensors of distance; None: a ring around its outline. `wheels` are its wheels, with
    `rollers` or without; none: two.
    """

    def __init__(
        self,
        settings: WorldSettings,
        sensors: Sequence[RangeSensor] | None = None,
        wheels: Sequence[Wheel] = (),
        *,
        rollers: bool = False,
    ) -> None:
        self.settings = settings
        self._wheels = tuple(wheels) or two_wheels(settings.body)
        super().__init__(mujoco.MjModel.from_xml_string(model_xml(settings, self._wheels, rollers=rollers)), settings)
        self._amps, self._drawn = [0.0] * len(self._wheels), [0.0] * len(self._wheels)
        self._power: dict[str, float] = {}
        self._still_steps = 0
        self.ranges_m: dict[str, float | None] = {}
        self._scans: dict[str, tuple[float | None, ...]] = {}
        self._beams: frozenset[Beam] = frozenset()
        self._charging = False
        sensors = ring(settings.body.length_m, settings.body.width_m) if sensors is None else sensors
        self._sensors = tuple(_seen_from_above(one) for one in sensors if one.level and one.rays == 1)
        self._rangers = Rangers(mujoco, self._model, sensors, settings.ultrasonic, settings.seed)
        self._dock = DockSense(mujoco, self._model, settings.dock, settings.body) if settings.dock else None
        self._placed = Placed(self._model)
        self._standing = frozenset(self._geoms(STANDING))
        self._walls = self._standing - {self._model.geom(DOCK).id if settings.dock else -1}
        self._robot = frozenset(self._geoms(ROBOT))
        joints = [self._model.joint(wheel.name) for wheel in self._wheels]
        self._wheel_q = [int(joint.qposadr[0]) for joint in joints]
        self._wheel_v = [int(joint.dofadr[0]) for joint in joints]
        mass_kg = settings.body.mass_kg
        self._rollers = Rollers(self._model, self._wheels, self._wheel_v, mass_kg, TIMESTEP_S) if rollers else None
        self._settle()
        self._sense()

    def step(self, left: float, right: float, dt_s: float) -> None:
        """Run the world for `dt_s` with the two motors at a fraction of full power, forward positive."""
        self.drive({"left": left, "right": right}, dt_s)

    def drive(self, powers: Mapping[str, float], dt_s: float) -> None:
        """Run the world for `dt_s` with motors at a fraction of full power, forward positive; others rest."""
        self._power = {motor: _limited(power) for motor, power in powers.items()}
        self._run(dt_s, rests=self.resting and not any(self._power.values()))

    @property
    def resting(self) -> bool:
        """Return whether nothing moves: then time passes without the physics, until the next power or change."""
        return self._still_steps >= _STILL_STEPS and not self._placed.changed and self.balls.still

    def sensed(self) -> Sensed:
        """Return the present measurements of devices."""
        per_turn = self.settings.body.counts_per_turn
        motors: dict[str, MotorSensed] = {}
        for at, wheel in enumerate(self._wheels):
            turns = float(self._data.qpos[self._wheel_q[at]]) / (2 * pi)
            speed_rpm = float(self._data.qvel[self._wheel_v[at]]) * 30 / pi
            known = motors.get(wheel.motor, MotorSensed(counts=int(turns * per_turn), speed_rpm=speed_rpm))
            amps_a, drawn_a = known.amps_a + self._amps[at], known.battery_amps_a + self._drawn[at]
            motors[wheel.motor] = replace(known, amps_a=amps_a, battery_amps_a=drawn_a)
        left, right = (motors.get(name, MotorSensed()) for name in TWO)
        return Sensed(
            battery_v=self.battery.voltage_v,
            amps_a=(left.amps_a, right.amps_a),
            battery_amps_a=(left.battery_amps_a, right.battery_amps_a),
            counts=(left.counts, right.counts),
            speeds_rpm=(left.speed_rpm, right.speed_rpm),
            motors=motors,
            ranges_m=self.ranges_m,
            scans_m=self._scans,
            imu=self.imu(),
            charging=self._charging,
            charging_a=self.battery.charging_a,
            beams=self._beams,
        )

    def place(self, box: WorldBox) -> None:
        """Place a thing with the next step, or move the one of its name; for any thread. Raise InputError without room
        for it."""
        body = self.settings.body
        self._placed.place(box, (*self._place()[:2], hypot(body.length_m, body.width_m) / 2))

    def remove(self, name: str) -> None:
        """Remove a placed thing; raise InputError if the name is unknown."""
        self._placed.remove(name)

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
            left=self._side(1.0),
            right=self._side(-1.0),
            touching=self.touching(),
            battery_v=self.battery.voltage_v,
            time_s=self.time_s,
            charging=self._charging,
        )

    def scene(self) -> WorldScene:
        """Return the fixed and the placed things, the robot's outline and its sensors."""
        settings = self.settings
        return WorldScene(
            walls=(*map(_box, settings.walls), *self._placed.things, *self.balls.boxes),
            robot_length_m=settings.body.length_m,
            robot_width_m=settings.body.width_m,
            dock=world_dock(settings.dock) if settings.dock else None,
            sensors=self._sensors,
        )

    def touching(self, *, dock: bool = False) -> bool:
        """Return whether the robot touches a thing in the room; `dock`: its dock counts, too."""
        data, things = self._data, self._standing if dock else self._walls
        pairs = (data.contact.geom[index] for index in range(data.ncon))
        return any((a in things and b in self._robot) or (b in things and a in self._robot) for a, b in pairs)

    def _side(self, sense: float) -> float:
        """Return the power of one side: the average of its wheels."""
        powers = [self._power.get(wheel.motor, 0.0) for wheel in self._wheels if wheel.y_m * sense > 0.0]
        return sum(powers) / max(1, len(powers))

    def _place(self) -> tuple[float, float, float]:
        x, y, _, qw, qx, qy, qz = (float(value) for value in self._data.qpos[:7])
        return x, y, atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))

    def _geoms(self, group: int) -> list[int]:
        return [index for index in range(self._model.ngeom) if self._model.geom_group[index] == group]

    def _settle(self) -> None:
        """Let the robot settle on its wheels before time begins."""
        start = self._data.qpos.copy()
        for _ in range(_SETTLING_STEPS):
            mujoco.mj_step(self._model, self._data)
        start[2:7] = self._data.qpos[2:7]
        self._data.qpos[:], self._data.qvel[:], self._data.time = start, 0.0, 0.0
        mujoco.mj_forward(self._model, self._data)
        self._imu.follow(self._data)

    def _passed(self, count: int) -> None:
        """Go on with battery and noise."""
        if not count:
            return
        self._draw(count * TIMESTEP_S)
        if self._steps // _SENSE_EVERY != (self._steps - count) // _SENSE_EVERY:
            self.ranges_m = self._rangers.again(self._steps - self._steps % _SENSE_EVERY)

    def _step_once(self) -> None:
        if self._placed.changed:
            self._still_steps = 0
        self._placed.apply(self._model, self._data)
        if self._steps % _SENSE_EVERY == 0:
            self.balls.apply(self._data)
        for index, wheel in enumerate(self._wheels):
            power = self._power.get(wheel.motor, 0.0)
            self._data.ctrl[index] = self._ramped(float(self._data.ctrl[index]), power, wheel.diameter_m / 2)
        if self._rollers is not None:
            self._rollers.push(self._data, self._place()[2])
        mujoco.mj_step(self._model, self._data)
        self._imu.follow(self._data)
        self._load()
        stands = not any(self._power.values()) and not self._data.ctrl.any()
        self._still_steps = self._still_steps + 1 if stands and np.abs(self._data.qvel).max() < _STILL else 0
        self._steps += 1
        if self._steps % _SENSE_EVERY == 0:
            self._sense()

    def _ramped(self, now_radps: float, power: float, radius: float) -> float:
        """Return the next wheel speed: motors accelerate and brake as the drive permits."""
        body = self.settings.body
        wanted = power * body.max_speed_mps / radius
        slowing = abs(wanted) < abs(now_radps) or wanted * now_radps < 0
        most = (body.deceleration_mps2 if slowing else body.acceleration_mps2) / radius * TIMESTEP_S
        return now_radps + max(-most, min(most, wanted - now_radps))

    def _load(self) -> None:
        """Update motor and battery currents from the torques."""
        torques, speeds = self._data.actuator_force.tolist(), self._data.qvel.tolist()
        for at, torque_nm in enumerate(torques):
            self._amps[at] += (torque_nm * _AMPS_PER_NM - self._amps[at]) * _AMPS_SETTLE
            duty = self._duty(speeds[self._wheel_v[at]], torque_nm, self._wheels[at].diameter_m / 2)
            self._drawn[at] = self._amps[at] * duty
        self._draw(TIMESTEP_S)

    def _draw(self, dt_s: float) -> None:
        dock = self.settings.dock
        self.battery.draw(sum(self._drawn), dt_s, dock.current_a if dock and self._charging else 0.0)

    def _duty(self, speed_radps: float, torque_nm: float, radius: float) -> float:
        """Return the duty of a bridge: that of the wheel's speed, and more under load."""
        full_radps = self.settings.body.max_speed_mps / radius
        return max(-1.0, min(1.0, speed_radps / full_radps + torque_nm / (2 * MAX_TORQUE_NM)))

    def _sense(self) -> None:
        """Look around: these measurements are less frequent than steps of the physics."""
        place = self._place()
        self.ranges_m = self._rangers.look(self._data, place, self._steps)
        self._scans = self._rangers.scan(self._data, place)
        if self._dock is not None:
            self._charging = self._dock.charging(place)
            self._beams = self._dock.beams(self._data, place)


def body_of(
    settings: WorldSettings, rows: Callable[[type[Any]], tuple[Any, ...]]
) -> tuple[tuple[RangeSensor, ...], tuple[Wheel, ...], bool]:
    """Return a robot's sensors of distance, its wheels, and whether these have rollers, by its rows."""
    sensors = rows(RangeSensor) or ring(settings.body.length_m, settings.body.width_m)
    base = next(iter(rows(Kinematics)), None)
    wheels, rollers = (rows(Wheel), base.kind in HOLONOMIC) if base else ((), False)
    return tuple(sensors), wheels, rollers


def _seen_from_above(sensor: RangeSensor) -> WorldSensor:
    return WorldSensor(name=sensor.name, x_m=sensor.x_m, y_m=sensor.y_m, yaw_rad=sensor.yaw_rad, fov_rad=sensor.fov_rad)


def _box(box: BoxSettings) -> WorldBox:
    return WorldBox(**msgspec.structs.asdict(box))


def _limited(power: float) -> float:
    return max(-1.0, min(1.0, power)) if isfinite(power) else 0.0
