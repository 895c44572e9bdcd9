"""Wheels with rollers on the floor: each pushes the base across its rollers, and slides along them."""

from collections.abc import Sequence
from math import cos, sin
from typing import NamedTuple

from lbr.messages.kinematics import Wheel
from lbr.simulation.bindings import MjData, MjModel

GRAVITY = 9.81
GRIP = 0.8
"""The greatest force across the rollers, as a share of the weight on the wheel: rubber on a smooth floor."""
STIFFNESS = 0.2
"""The share of the force that would end all slip within one step; with more, the steps oscillate."""


class _Contact(NamedTuple):
    """A wheel's contact with the floor: its place, the direction of its push, and its speed at one radian a second."""

    x_m: float
    y_m: float
    along_x: float
    along_y: float
    metres: float
    dof: int


class Rollers:
    """The forces of the floor on a base with such wheels; call `push` before each step of the physics."""

    def __init__(
        self, model: MjModel, wheels: Sequence[Wheel], dofs: Sequence[int], mass_kg: float, step_s: float
    ) -> None:
        self._base = int(model.body("base").id)
        self._contacts = [_contact(wheel, dof) for wheel, dof in zip(wheels, dofs, strict=True)]
        each_kg = mass_kg / len(wheels)
        self._most_n, self._per_mps = GRIP * each_kg * GRAVITY, STIFFNESS * each_kg / step_s

    def push(self, data: MjData, yaw: float) -> None:
        """Set the floor's forces on base and wheels, by their present motion."""
        c, s = cos(yaw), sin(yaw)
        east_mps, north_mps, turn_rps = (float(data.qvel[axis]) for axis in (0, 1, 5))
        ahead_mps, aside_mps = c * east_mps + s * north_mps, c * north_mps - s * east_mps
        ahead_n = aside_n = turn_nm = 0.0
        for at in self._contacts:
            floor_mps = at.along_x * (ahead_mps - turn_rps * at.y_m) + at.along_y * (aside_mps + turn_rps * at.x_m)
            slip_mps = float(data.qvel[at.dof]) * at.metres - floor_mps
            force_n = max(-self._most_n, min(self._most_n, slip_mps * self._per_mps))
            data.qfrc_applied[at.dof] = -force_n * at.metres
            ahead_n += force_n * at.along_x
            aside_n += force_n * at.along_y
            turn_nm += force_n * (at.x_m * at.along_y - at.y_m * at.along_x)
        data.xfrc_applied[self._base] = (c * ahead_n - s * aside_n, s * ahead_n + c * aside_n, 0.0, 0.0, 0.0, turn_nm)


def _contact(wheel: Wheel, dof: int) -> _Contact:
    across = wheel.yaw_rad + wheel.roller_rad
    metres = wheel.diameter_m / 2 * cos(wheel.roller_rad)
    return _Contact(wheel.x_m, wheel.y_m, cos(across), sin(across), metres, dof)
