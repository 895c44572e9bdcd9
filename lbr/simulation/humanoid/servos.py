"""The servo motors of a body, controlled by their registers, all at once."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from lbr.messages.joints import Joint
from lbr.simulation.humanoid.settings import Motor
from lbr.simulation.measured import ServoDrive, ServoFelt

Floats = NDArray[np.float64]
Servo = int | tuple[str, int]
"""A servo of a body: its number, with the bus before it if its joint's row names one."""

_LIMP_NMS = 0.01
"""Damping of a motor without supply; a driven or shorted one brakes as a generator."""

_ANY_SPEED_RPS = 1e6
_THERE_RAD = 1e-6


def servo(bus: str, number: int) -> Servo:
    """Return the key of a servo."""
    return (bus, number) if bus else number


class Servos:
    """The motors of the joints, in the joints' radians and in the order of the rows.

    `limp` are those without torque, all until they are driven; `load` is the torque of each as a share of its maximum.
    """

    def __init__(self, joints: Sequence[Joint], motors: Sequence[Motor]) -> None:
        count = len(joints)
        self._ids = [servo(joint.bus, joint.device_id) for joint in joints]
        self._sign = np.array([float(joint.sign) for joint in joints])
        self._zero = np.array([joint.zero_rad for joint in joints])
        self._stall_nm, self._stall_a, self._rated_v = (
            np.array([getattr(motor, name) for motor in motors]) for name in ("stall_nm", "stall_a", "rated_v")
        )
        self._driven_nms = self._stall_nm / np.array([motor.no_load_rps for motor in motors])
        self._drives: Mapping[Servo, ServoDrive] = {}
        self._goal, self._torque, self._target = np.zeros(count), np.zeros(count), np.zeros(count)
        self._speed, self._punch = np.full(count, _ANY_SPEED_RPS), np.zeros(count)
        self._margins, self._slopes = np.zeros((2, count)), np.ones((2, count))
        self.limp = np.full(count, True)
        self.damping_nms = np.full(count, _LIMP_NMS)
        self.load = np.zeros(count)

    @property
    def on_their_way(self) -> bool:
        """Return whether any servo is still on its way to its goal."""
        return bool((~self.limp & (np.abs(self._target - self._goal) > _THERE_RAD)).any())

    def driven(self, drives: Mapping[Servo, ServoDrive]) -> bool:
        """Return whether the registers are as they were at the last step."""
        return drives == self._drives

    def follow(self, drives: Mapping[Servo, ServoDrive]) -> bool:
        """Follow the registers; return whether they have changed."""
        if drives == self._drives:
            return False
        self._drives = drives
        limp = ServoDrive()
        given = [drives.get(number, limp) for number in self._ids]
        self._goal = self._sign * (np.array([drive.goal_rad for drive in given]) - self._zero)
        speeds = (drive.speed_rps for drive in given)
        self._speed = np.array([_ANY_SPEED_RPS if speed is None else speed for speed in speeds])
        self._torque = np.array([drive.torque for drive in given])
        self._punch = np.array([drive.punch for drive in given])
        self._margins = self._sided([drive.margins_rad for drive in given])
        self._slopes = np.maximum(self._sided([drive.slopes_rad for drive in given]), 1e-3)
        self.limp = self._torque <= 0.0
        shorted = np.array([drive.brake for drive in given])
        self.damping_nms = np.where(self.limp & ~shorted, _LIMP_NMS, self._driven_nms)
        return True

    def torques(self, position: Floats, speed: Floats, supply_v: float, dt_s: float) -> Floats:
        """Return the motors' torques on their joints, without the braking of `damping_nms`, and keep their `load`."""
        most = self._speed * dt_s
        way = np.minimum(np.maximum(self._goal - self._target, -most), most)
        self._target = np.where(self.limp, position, self._target + way)
        error = self._target - position
        up, size = error > 0, np.abs(error)
        margin = np.where(up, self._margins[1], self._margins[0])
        slope = np.where(up, self._slopes[1], self._slopes[0])
        drive = np.minimum(self._torque, self._punch + (size - margin) / slope)
        drive = np.where((size <= margin) | self.limp, 0.0, np.copysign(drive, error))
        torque: Floats = drive * (self._stall_nm * supply_v / self._rated_v)
        self.load = np.where(self.limp, 0.0, (torque - self.damping_nms * speed) / self._stall_nm)
        return torque

    def felt(self, position: Floats, speed: Floats) -> dict[Servo, ServoFelt]:
        """Return the servos' measurements, in their own radians."""
        positions = (self._zero + self._sign * position).tolist()
        speeds, loads = (self._sign * speed).tolist(), (self._sign * self.load).tolist()
        each = zip(self._ids, positions, speeds, loads, strict=True)
        return {number: ServoFelt(position_rad=at, speed_rps=going, load=load) for number, at, going, load in each}

    def amps(self) -> float:
        """Return the current of all motors."""
        return float((np.abs(self.load) * self._stall_a).sum())

    def _sided(self, pairs: list[tuple[float, float]]) -> Floats:
        """Return clockwise and anticlockwise values as those below and above, for a joint that may count the other
        way."""
        below, above = np.array(pairs).T
        return np.array([np.where(self._sign > 0, below, above), np.where(self._sign > 0, above, below)])
