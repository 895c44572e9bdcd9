"""Coloured balls in the world of a humanoid: each keeps to its path, until it is put elsewhere."""

from collections.abc import Mapping
from math import cos, pi, sin
from typing import Any

from lbr.errors import InputError
from lbr.simulation.humanoid.body import BALL
from lbr.simulation.humanoid.settings import Ball
from lbr.simulation.requests import BallRequest

_GONE = (0.0, 0.0, -10.0)

Place = tuple[float, float, float]


class Balls:
    """Any thread may ask; `apply` does it between two steps of the physics."""

    def __init__(self, model: Any, balls: Mapping[str, Ball]) -> None:
        self._balls = dict(balls)
        self._placed: dict[str, Place] = {}
        self._mocaps = {name: int(model.body_mocapid[model.body(BALL.format(name)).id]) for name in balls}

    def put(self, request: BallRequest) -> str:
        """Put a ball elsewhere, back on its path, or away, and say so; raise InputError naming those that there are."""
        if request.name not in self._balls:
            known = ", ".join(self._balls) or "none"
            raise InputError(
                f"there is no ball '{request.name}'; the world's setting `balls` has: {known}", "unknown_name"
            )
        if request.gone:
            self._placed[request.name] = _GONE
            return f"'{request.name}' is gone"
        ball, given = self._balls[request.name], (request.x_m, request.y_m, request.z_m)
        if all(value is None for value in given):
            self._placed.pop(request.name, None)
            return f"'{request.name}' is back where it was"
        usual = (ball.x_m, ball.y_m, ball.z_m)
        x, y, z = (own if value is None else value for value, own in zip(given, usual, strict=True))
        self._placed[request.name] = (x, y, z)
        return f"'{request.name}' is at {x:.2f}, {y:.2f}, {z:.2f} m"

    def apply(self, data: Any) -> None:
        """Put every ball where it is now."""
        for name, mocap in self._mocaps.items():
            data.mocap_pos[mocap] = self._placed.get(name) or _on_path(self._balls[name], data.time)


def _on_path(ball: Ball, time_s: float) -> Place:
    turn = 2 * pi * time_s / ball.period_s
    aside, up = {
        "rest": (0.0, 0.0),
        "to_and_fro": (sin(turn), 0.0),
        "circle": (cos(turn), sin(turn)),
    }[ball.path]
    return ball.x_m, ball.y_m + ball.reach_m * aside, ball.z_m + ball.reach_m * up
