"""A hand that takes joints in turn and moves them, as a person does who shows a limp arm a pose."""

from collections.abc import Sequence
from math import degrees, radians

import numpy as np

from lbr.errors import InputError
from lbr.simulation.humanoid.servos import Floats
from lbr.simulation.requests import HandRequest

STIFFNESS_NM, DAMPING_NMS, STRONGEST_NM = 30.0, 1.2, 6.0
"""Stiff enough to carry a stretched arm of half a kilogram within two degrees, and damped for its lightest joint."""
SPEED_RPS = 1.5


class Grip:
    """The hand. Any thread may ask; `torques` is its effect between two steps of the physics."""

    def __init__(self, names: Sequence[str]) -> None:
        self._names = list(names)
        self._free, self._nothing = np.full(len(names), np.nan), np.zeros(len(names))
        self._goal = self._at = self._free
        self._followed = self._free

    @property
    def still(self) -> bool:
        """Return whether it has begun all requests."""
        return self._goal is self._followed

    def take(self, request: HandRequest) -> str:
        """Move a joint, or release all, and return a report; raise InputError if there is no such joint."""
        goal = self._goal.copy()
        if request.gone:
            goal = self._free
        elif request.joint in self._names:
            goal[self._names.index(request.joint)] = radians(request.angle_deg)
        else:
            raise InputError(f"there is no joint '{request.joint}'", "unknown_name")
        self._goal = goal
        held = [f"{name} at {degrees(at):.0f}" for name, at in zip(self._names, goal, strict=True) if not np.isnan(at)]
        return f"a hand holds {', '.join(held)} degrees" if held else "the hand is gone"

    def torques(self, position: Floats, speed: Floats, dt_s: float) -> Floats:
        """Return the hand's torque on each joint; 0 where it is not."""
        goal = self._followed = self._goal
        if goal is self._free:
            self._at = goal
            return self._nothing
        at = np.where(np.isnan(self._at), position, self._at)
        most = SPEED_RPS * dt_s
        self._at = np.where(np.isnan(goal), np.nan, at + np.clip(goal - at, -most, most))
        pull = np.clip(STIFFNESS_NM * (self._at - position) - DAMPING_NMS * speed, -STRONGEST_NM, STRONGEST_NM)
        found: Floats = np.where(np.isnan(goal), 0.0, pull)
        return found
