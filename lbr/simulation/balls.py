"""Coloured balls in a simulated world, visible only: each follows its path, until it is put elsewhere."""

from collections.abc import Mapping
from math import cos, pi, sin
from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.context import Call, Context
from lbr.errors import InputError
from lbr.simulation.bindings import MjData, MjModel
from lbr.simulation.messages import WorldBox
from lbr.simulation.requests import BallReply, BallRequest
from lbr.simulation.room import Colour, Place

BALL = "ball {}"
"""The name of a ball's body."""
_GONE = (0.0, 0.0, -10.0)

Middle = tuple[float, float, float]


class Ball(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A coloured ball, visible only: its first position, and its path around that.

    `to_and_fro`: `reach_m` to the left and right; `circle`: at `reach_m`, in the plane across x. `gone`: absent until
    it is put somewhere.
    """

    x_m: Place = 1.0
    y_m: Place = 0.0
    z_m: Place = 0.9
    radius_m: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.06
    colour: Colour = "#f07818"
    path: Literal["rest", "to_and_fro", "circle"] = "rest"
    reach_m: Annotated[float, Meta(ge=0.0, le=10.0)] = 0.4
    period_s: Annotated[float, Meta(ge=0.5, le=3600.0)] = 8.0
    gone: bool = False


class Balls:
    """The balls of a world. Any thread may ask; `apply` changes them between two steps of the physics."""

    def __init__(self, model: MjModel, balls: Mapping[str, Ball]) -> None:
        self._balls = dict(balls)
        self._placed: dict[str, Middle] = {}
        self._changed = False
        self._mocaps = {name: int(model.body_mocapid[model.body(BALL.format(name)).id]) for name in balls}

    @property
    def still(self) -> bool:
        """Return whether no ball moves or is about to be put elsewhere."""
        return not self._changed and all(self._rests(name) for name in self._balls)

    @property
    def boxes(self) -> tuple[WorldBox, ...]:
        """Return the present balls at rest, as boxes for the view from above."""
        found = {name: self._where(name, 0.0) for name in self._balls if self._rests(name)}
        return tuple(_box(name, self._balls[name], at) for name, at in found.items() if at != _GONE)

    def put(self, request: BallRequest) -> str:
        """Put a ball elsewhere, back on its path, or away, and return a sentence; InputError names the known balls."""
        if request.name not in self._balls:
            known = ", ".join(self._balls) or "none"
            raise InputError(
                f"there is no ball '{request.name}'; the world's setting `balls` has: {known}", "unknown_name"
            )
        ball, given = self._balls[request.name], (request.x_m, request.y_m, request.z_m)
        as_it_began = all(value is None for value in given)
        if request.gone or (as_it_began and ball.gone):
            self._placed[request.name] = _GONE
            text = f"'{request.name}' is gone"
        elif as_it_began:
            self._placed.pop(request.name, None)
            text = f"'{request.name}' is back where it was"
        else:
            usual = (ball.x_m, ball.y_m, ball.z_m)
            x, y, z = (own if value is None else value for value, own in zip(given, usual, strict=True))
            self._placed[request.name] = (x, y, z)
            text = f"'{request.name}' is at {x:.2f}, {y:.2f}, {z:.2f} m"
        self._changed = True
        return text

    def answer(self, ctx: Context[Struct], call: Call, request: BallRequest) -> None:
        """Put a ball elsewhere for a call, and answer it."""
        try:
            text = self.put(request)
        except InputError as err:
            call.refuse(str(err), err.code)
            return
        ctx.event("world_changed", text, code="done", about=call.source)
        call.reply(BallReply(accepted=True, reason=text))

    def middle(self, name: str, time_s: float) -> Middle | None:
        """Return the position of a ball; None if it is gone, or unknown."""
        at = self._where(name, time_s) if name in self._balls else _GONE
        return None if at == _GONE else at

    def apply(self, data: MjData) -> None:
        """Put every ball at its present position."""
        self._changed = False
        for name, mocap in self._mocaps.items():
            data.mocap_pos[mocap] = self._where(name, data.time)

    def _rests(self, name: str) -> bool:
        return name in self._placed or self._balls[name].gone or self._balls[name].path == "rest"

    def _where(self, name: str, time_s: float) -> Middle:
        ball = self._balls[name]
        return self._placed.get(name) or (_GONE if ball.gone else _on_path(ball, time_s))


def first_place(ball: Ball) -> Middle:
    """Return the position of a ball before the world has run."""
    return _GONE if ball.gone else (ball.x_m, ball.y_m, ball.z_m)


def _on_path(ball: Ball, time_s: float) -> Middle:
    turn = 2 * pi * time_s / ball.period_s
    aside, up = {
        "rest": (0.0, 0.0),
        "to_and_fro": (sin(turn), 0.0),
        "circle": (cos(turn), sin(turn)),
    }[ball.path]
    return ball.x_m, ball.y_m + ball.reach_m * aside, ball.z_m + ball.reach_m * up


def _box(name: str, ball: Ball, at: Middle) -> WorldBox:
    across = 2 * ball.radius_m
    return WorldBox(
        name=name,
        x_m=at[0],
        y_m=at[1],
        length_m=across,
        width_m=across,
        kind="cylinder",
        bottom_m=at[2] - ball.radius_m,
        height_m=across,
        colour=ball.colour,
        solid=False,
    )
