"""The physics of a humanoid: its joints moved by servos, on a floor, and the measurements of its devices."""

from collections.abc import Mapping, Sequence
from math import asin, atan2, cos, radians, sin
from typing import Any

import numpy as np
from msgspec.structs import replace

from lbr.errors import InputError
from lbr.messages.joints import Joint
from lbr.simulation.bindings import MjData
from lbr.simulation.humanoid.body import FLOOR, TIMESTEP_S, Body, heading_rad, load, model_file
from lbr.simulation.humanoid.grip import Grip
from lbr.simulation.humanoid.servos import Floats, Servo, Servos
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from lbr.simulation.humanoid.stillness import Stillness
from lbr.simulation.measured import Sensed, ServoDrive, ServoFelt
from lbr.simulation.messages import HumanoidPose
from lbr.simulation.physics import mujoco
from lbr.simulation.stepped import SteppedEngine

_UPRIGHT = cos(radians(45.0))
_STAND_M = 0.05
"""The height of the feet above the floor on a stand."""

_HAND_EVERY, _HAND_MPS = 5, 0.3
_STANDS = 0.85
"""The height of a standing trunk, as a share of that with every joint at zero."""

_WELL_ABOVE = 0.4
"""The permitted distance of its weight from the middle of its feet, as a share of their span."""


class HumanoidEngine(SteppedEngine):
    """The world of one humanoid; the same steps with the same seed give the same run."""

    def __init__(self, settings: HumanoidWorldSettings, joints: Sequence[Joint], home: str) -> None:
        self.settings = settings
        self.body: Body = load(model_file(settings.model, home), joints, settings)
        super().__init__(self.body.model, settings)
        self.buses = frozenset(joint.bus for joint in joints)
        """The buses that the joints' rows name."""
        self._names = [joint.name for joint in joints]
        self._servos = Servos(_as_built(joints, settings), settings.motors_of(self._names))
        self.grip = Grip(self._names)
        self._rest_rad = _angles(settings.rests, self._names)
        self._driven_s = 0.0
        self._stillness = Stillness(self._data.qpos)
        self._floor = self._model.geom(FLOOR).id
        mujoco.mj_kinematics(self._model, self._data)
        self._tall_m = float(self._data.xpos[self.body.trunk, 2])
        self.pick_up()

    @property
    def data(self) -> MjData:
        """Return the physics engine's state, for reading."""
        return self._data

    @property
    def held(self) -> bool:
        """Return whether a hand or a stand holds it."""
        return bool(self._data.eq_active[0])

    @property
    def resting(self) -> bool:
        """Return whether nothing moves or is about to: then time passes without the physics."""
        return self._stillness.rests(self.battery.voltage_v) and self.grip.still

    def put(self, angles: Sequence[float], foot: str = "") -> None:
        """Put it on the floor with these joint angles, at rest, without a hand: upright, or with a foot flat on the
        floor."""
        data = self._data
        data.qpos[self.body.positions] = angles
        data.qvel[:] = 0.0
        data.qpos[2:7] = (0.0, 1.0, 0.0, 0.0, 0.0)
        mujoco.mj_kinematics(self._model, data)
        if foot:
            data.qpos[3:7] = self._on_soles(foot)
            mujoco.mj_kinematics(self._model, data)
        data.qpos[2] = -self._lowest_m()
        data.eq_active[0] = False
        mujoco.mj_forward(self._model, data)
        self._imu.follow(data)
        self._stillness.end()

    def turn(self, roll_rad: float, pitch_rad: float, yaw_rad: float, above_m: float) -> None:
        """Turn it with its joints unchanged, so that its lowest part is so far above the floor."""
        data, quaternion = self._data, np.zeros(4)
        mujoco.mju_euler2Quat(quaternion, np.array((yaw_rad, pitch_rad, roll_rad)), "zyx")
        data.qpos[3:7] = quaternion
        mujoco.mj_kinematics(self._model, data)
        data.qpos[2] += above_m - self._lowest_m()
        mujoco.mj_forward(self._model, data)
        self._imu.follow(data)
        self._stillness.end()

    def push(self, ahead_mps: float, left_mps: float) -> None:
        """Push the trunk, so that all of it goes so much faster."""
        self._data.qvel[:2] += (ahead_mps, left_mps)
        self._stillness.end()

    def pick_up(self) -> None:
        """Put it back into its first pose at its present place and heading: limp joints at zero, or at rest.

        A hand holds it upright until it can stand. If all joints are limp and it has a rest, it rests instead.
        """
        data, limp = self._data, self._servos.limp
        rests = bool(self.settings.rests) and bool(limp.all()) and not self.settings.stand
        yaw = heading_rad(data.xmat[self.body.trunk])
        data.qpos[self.body.positions] = np.where(limp, self._rest_rad, data.qpos[self.body.positions])
        data.qvel[:] = 0.0
        data.qpos[2:7] = (0.0, 1.0, 0.0, 0.0, 0.0)
        mujoco.mj_kinematics(self._model, data)
        lean = self._on_soles() if rests else (1.0, 0.0, 0.0, 0.0)
        mujoco.mju_mulQuat(data.qpos[3:7], (cos(yaw / 2), 0.0, 0.0, sin(yaw / 2)), lean)
        mujoco.mj_kinematics(self._model, data)
        data.qpos[2] = (_STAND_M if self.settings.stand else 0.0) - self._lowest_m()
        if self.settings.rests and not rests:
            data.qpos[2] = max(data.qpos[2], self._tall_m)
        data.mocap_pos[0], data.mocap_quat[0] = data.qpos[:3], data.qpos[3:7]
        data.eq_active[0] = not rests
        self._driven_s = 0.0
        self.balls.apply(data)
        mujoco.mj_forward(self._model, data)
        self._imu.follow(data)
        self._stillness.end()

    def step(self, drives: Mapping[Servo, ServoDrive], dt_s: float) -> None:
        """Run the world for `dt_s` with these states of the servos' motors."""
        if self._servos.follow(drives):
            self._model.dof_damping[self.body.speeds] = self._servos.damping_nms
            self._stillness.end()
        self._run(dt_s, rests=self.resting)

    def driven(self, drives: Mapping[Servo, ServoDrive]) -> bool:
        """Return whether the servos' motors have these states already."""
        return self._servos.driven(drives)

    def felt(self) -> dict[Servo, ServoFelt]:
        """Return the present measurements of the servos."""
        return self._servos.felt(*self._joints())

    def sensed(self) -> Sensed:
        """Return the present measurements of devices other than the servos."""
        return Sensed(battery_v=self.battery.voltage_v, imu=self.imu())

    def pose(self) -> HumanoidPose:
        """Return the truth about the robot."""
        x, y, z, qw, qx, qy, qz = self._data.qpos[:7].tolist()
        upright = 1 - 2 * (qx * qx + qy * qy) > _UPRIGHT
        return HumanoidPose(
            x_m=x,
            y_m=y,
            z_m=z,
            roll_rad=atan2(2 * (qw * qx + qy * qz), 1 - 2 * (qx * qx + qy * qy)),
            pitch_rad=asin(max(-1.0, min(1.0, 2 * (qw * qy - qz * qx)))),
            yaw_rad=atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz)),
            upright=upright,
            stands=upright and z > _STANDS * self._tall_m,
            held=self.held,
            on_floor=self._on_floor(),
            joints=dict(zip(self._names, self._joints()[0].tolist(), strict=True)),
            supply_v=self.battery.voltage_v,
            time_s=self.time_s,
        )

    def _joints(self) -> tuple[Floats, Floats]:
        return self._data.qpos[self.body.positions], self._data.qvel[self.body.speeds]

    def _passed(self, count: int) -> None:
        """Go on with battery, balls and noise."""
        self.battery.draw(self._servos.amps(), count * TIMESTEP_S)
        if not self.balls.still:
            self.balls.apply(self._data)
            mujoco.mj_kinematics(self._model, self._data)

    def _step_once(self) -> None:
        position, speed = self._joints()
        torque = self._servos.torques(position, speed, self.battery.voltage_v, TIMESTEP_S)
        self._data.qfrc_applied[self.body.speeds] = torque + self.grip.torques(position, speed, TIMESTEP_S)
        mujoco.mj_step(self._model, self._data)
        self._imu.follow(self._data)
        self.battery.draw(self._servos.amps(), TIMESTEP_S)
        self._steps += 1
        self._driven_s = 0.0 if self._servos.limp.any() else self._driven_s + TIMESTEP_S
        if self._steps % _HAND_EVERY == 0:
            self.balls.apply(self._data)
            if self.held and not self.settings.stand:
                self._hold()
            if self._stillness.look(self._data.qpos, self.time_s, self.battery.voltage_v, about_to=self._about_to):
                self._stand_still()

    @property
    def _about_to(self) -> bool:
        """Return whether servos are on their way, or the hand may open soon."""
        return self._servos.on_their_way or (self.held and not self.settings.stand and not self._servos.limp.any())

    def _stand_still(self) -> None:
        """Remove the rest of motion, which comes from the model's contacts, and its effect on the inertial unit."""
        data = self._data
        data.qvel[:] = 0.0
        mujoco.mj_forward(self._model, data)
        data.qacc[:] = 0.0
        mujoco.mj_rnePostConstraint(self._model, data)
        mujoco.mj_sensorAcc(self._model, data)
        self._imu.settle(data)

    def _hold(self) -> None:
        """Move the helper's hand so that the feet are on the floor, and open it once the robot can stand."""
        if self._driven_s >= self.settings.hand_s and self._balanced():
            self._data.eq_active[0] = False
            return
        most = _HAND_MPS * TIMESTEP_S * _HAND_EVERY
        self._data.mocap_pos[0, 2] += max(-most, min(most, -self._lowest_m()))

    def _on_soles(self, foot: str = "") -> Floats:
        """Return the turn of the trunk with a foot flat on the floor, from the positions with the trunk unturned."""
        turned = np.array((1.0, 0.0, 0.0, 0.0))
        if self.body.feet:
            mujoco.mju_negQuat(
                turned, self._data.xquat[self.body.feet.get(foot) or next(iter(self.body.feet.values()))]
            )
        return turned

    def _balanced(self) -> bool:
        """Return whether it stands on all its feet, with its weight well above them."""
        if not set(self.body.feet) <= set(self._on_floor()):
            return False
        soles = np.flatnonzero(np.isin(self._model.geom_bodyid, list(self.body.feet.values())) & self.body.solid)
        turned = np.abs(self._data.geom_xmat[soles].reshape(-1, 3, 3)[:, :2])
        half = np.einsum("gij,gj->gi", turned, self._model.geom_aabb[soles, 3:])
        middle = self._data.geom_xpos[soles, :2]
        low, high = (middle - half).min(axis=0), (middle + half).max(axis=0)
        off = np.abs(self._data.subtree_com[self.body.trunk][:2] - (low + high) / 2) / (high - low)
        return bool((off < _WELL_ABOVE).all())

    def _on_floor(self) -> tuple[str, ...]:
        pairs = self._data.contact.geom[: self._data.ncon].tolist()
        geoms = {a if b == self._floor else b for a, b in pairs if self._floor in (a, b)}
        return tuple(sorted({self._model.body(self._model.geom_bodyid[geom]).name for geom in geoms}))

    def _lowest_m(self) -> float:
        """Return the height of its lowest part."""
        solid = np.flatnonzero(self.body.solid)
        turned = self._data.geom_xmat[solid].reshape(-1, 3, 3)[:, 2]
        middle = self._data.geom_xpos[solid, 2] + (turned * self._model.geom_aabb[solid, :3]).sum(axis=1)
        lowest: Any = (middle - (np.abs(turned) * self._model.geom_aabb[solid, 3:]).sum(axis=1)).min()
        return float(lowest)


def _as_built(joints: Sequence[Joint], settings: HumanoidWorldSettings) -> list[Joint]:
    """Return the real mounting of the servos on their joints."""
    if unknown := sorted(settings.mounted.keys() - {joint.name for joint in joints}):
        raise InputError(f"world setting `mounted`: there is no joint '{unknown[0]}'")
    found = ((joint, settings.mounted.get(joint.name)) for joint in joints)
    return [joint if one is None else replace(joint, zero_rad=one.zero_rad, sign=one.sign) for joint, one in found]


def _angles(given: Mapping[str, float], names: Sequence[str]) -> Floats:
    unknown = sorted(set(given) - set(names))
    if unknown:
        raise InputError(f"world setting `rests`: there is no joint '{unknown[0]}'")
    return np.array([given.get(name, 0.0) for name in names])
