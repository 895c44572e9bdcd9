"""A humanoid drawn from its front and its left, in parallel projection; needs Pillow."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from lbr.simulation.bindings import MjData, MjModel
from lbr.simulation.humanoid.body import Body, heading_rad
from lbr.simulation.humanoid.servos import Floats
from lbr.simulation.messages import HumanoidPose
from lbr.simulation.physics import mujoco

if TYPE_CHECKING:
    from PIL.Image import Image

_PAPER, _INK, _FLOOR, _FALLEN = (250, 250, 247), (30, 34, 40), (208, 200, 186), (207, 34, 46)
_LEGEND_PX = 46
_LIGHT = np.array([0.5, 0.35, 0.79])

Colour = tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class _View:
    """A direction of view: the axes to the right and towards the viewer, in the robot's axes."""

    title: str
    right: Floats
    towards: Floats


_FRONT = _View("from the front", np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0]))
_LEFT = _View("from its left", np.array([-1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))


def portrait(body: Body, view: bytes, pose: HumanoidPose, size: tuple[int, int]) -> "Image":
    """Return the robot at a view of the engine, side by side from the front and from its left."""
    from PIL import Image, ImageDraw, ImageFont

    data = mujoco.MjData(body.model)
    data.qpos[:] = np.frombuffer(view, count=body.model.nq)
    mujoco.mj_kinematics(body.model, data)
    faces = _turned(_faces(body.model, data, body.trunk), pose, heading_rad(data.xmat[body.trunk]))
    tall, wide = _room_m(body)
    dots_per_m = min(max(1.0, size[1] - _LEGEND_PX) / tall, size[0] / 2 / wide)
    picture = Image.new("RGB", size, _PAPER)
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(size=13)
    ground = size[1] - _LEGEND_PX
    draw.rectangle([(0, ground), (size[0], size[1])], fill=_FLOOR)
    for number, looked in enumerate((_FRONT, _LEFT)):
        middle = size[0] * (1 + 2 * number) / 4
        for face, colour in _ordered(faces, looked):
            across, up = face @ looked.right * dots_per_m + middle, ground - face[:, 2] * dots_per_m
            dots = list(zip(across.tolist(), up.tolist(), strict=True))
            draw.polygon(dots, fill=colour, outline=_INK)
        draw.text((middle - 40, 8), looked.title, fill=_INK, font=font)
    draw.text((10, ground + 5), _legend(pose), fill=_INK if pose.upright else _FALLEN, font=font)
    draw.text((10, ground + 23), _standing_on(pose), fill=_INK, font=font)
    return picture


def _faces(model: MjModel, data: MjData, trunk: int) -> list[tuple[Floats, Floats, Colour]]:
    """Return every visible face of the robot: its corners, normal and colour; round bodies as their bounding boxes."""
    faces = []
    for geom in range(model.ngeom):
        if model.body_rootid[model.geom_bodyid[geom]] != trunk or model.geom_rgba[geom, 3] == 0.0:
            continue
        turned = data.geom_xmat[geom].reshape(3, 3)
        half = model.geom_aabb[geom, 3:]
        middle = data.geom_xpos[geom] + turned @ model.geom_aabb[geom, :3]
        red, green, blue = (model.geom_rgba[geom, :3] * 255).astype(int).tolist()
        for axis in range(3):
            for sign in (-1.0, 1.0):
                corners = _corners(axis, sign) * half
                faces.append((middle + corners @ turned.T, sign * turned[:, axis], (red, green, blue)))
    return faces


def _corners(axis: int, sign: float) -> Floats:
    """Return one face of a cube of half size 1."""
    square = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    return np.insert(square, axis, sign, axis=1)


def _turned(
    faces: Iterable[tuple[Floats, Floats, Colour]], pose: HumanoidPose, heading: float
) -> list[tuple[Floats, Floats, Colour]]:
    """Return faces around the robot's own place, as if its heading were x."""
    c, s = np.cos(-heading), np.sin(-heading)
    back = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    here = np.array([pose.x_m, pose.y_m, 0.0])
    return [((corners - here) @ back.T, back @ normal, colour) for corners, normal, colour in faces]


def _ordered(faces: list[tuple[Floats, Floats, Colour]], looked: _View) -> list[tuple[Floats, Colour]]:
    """Return the visible faces, the furthest first, in their light."""
    seen = [face for face in faces if face[1] @ looked.towards > 0.0]
    seen.sort(key=lambda face: float((face[0] @ looked.towards).mean()))
    return [(corners, _lit(colour, normal, looked)) for corners, normal, colour in seen]


def _lit(colour: Colour, normal: Floats, looked: _View) -> Colour:
    lamp = looked.right * _LIGHT[1] + looked.towards * _LIGHT[0] + np.array([0.0, 0.0, _LIGHT[2]])
    share = 0.72 + 0.28 * max(0.0, float(normal @ lamp))
    red, green, blue = (min(255, int(part * share)) for part in colour)
    return red, green, blue


def _room_m(body: Body) -> tuple[float, float]:
    """Return the height and width of a view: enough for the body with its arms raised, or lying."""
    trunk_m = float(body.model.body_pos[body.trunk, 2])
    return trunk_m * 1.9, trunk_m * 1.45


def _legend(pose: HumanoidPose) -> str:
    lean = f"roll {degrees(pose.roll_rad):+.0f} deg   pitch {degrees(pose.pitch_rad):+.0f} deg"
    return f"{pose.posture}   trunk {pose.z_m * 100:.0f} cm high   {lean}   {pose.supply_v:.1f} V   {pose.time_s:.1f} s"


def _standing_on(pose: HumanoidPose) -> str:
    return f"on the floor: {', '.join(part.replace('_', ' ') for part in pose.on_floor) or 'nothing'}"
