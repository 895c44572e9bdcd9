"""Two ways to draw a camera's view: OpenGL without a screen, and rays for a machine without it."""

from types import ModuleType
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lbr.simulation.bindings import MjData, MjModel
from lbr.simulation.cameras.egl import EglContext

Image = NDArray[np.uint8]
"""Rows from the top, pixels from the left, red, green, blue."""

LARGEST_PX = (1920, 1080)
SKY = (184, 207, 229)

_RAYS_ACROSS = 160
_FAR_M = 60.0
_AMBIENT = 0.45
_GEOM_LIMIT = 2000


class Renderer(Protocol):
    """Draws the view of a camera of the model."""

    name: str

    def draw(self, camera: str, width_px: int, height_px: int) -> Image:
        """Return a picture of the present world; of any size up to the requested one."""

    def close(self) -> None:
        """Release its resources."""


class GlRenderer:
    """MuJoCo's own renderer in an EGL context; without shadows, which cost more than all the rest."""

    name = "OpenGL (EGL)"

    def __init__(self, mujoco: ModuleType, model: MjModel, data: MjData) -> None:
        self._mujoco, self._model, self._data = mujoco, model, data
        self._egl = EglContext()
        self._room = (model.vis.global_.offwidth, model.vis.global_.offheight)
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._scene = mujoco.MjvScene(model, _GEOM_LIMIT)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        self._options = mujoco.MjvOption()
        self._options.flags[mujoco.mjtVisFlag.mjVIS_RANGEFINDER] = 0
        self._camera = mujoco.MjvCamera()
        self._camera.type = mujoco.mjtCamera.mjCAMERA_FIXED

    def draw(self, camera: str, width_px: int, height_px: int) -> Image:
        """Return a picture of the present world."""
        mujoco, scene = self._mujoco, self._scene
        if width_px > self._room[0] or height_px > self._room[1]:
            self._room = (max(width_px, self._room[0]), max(height_px, self._room[1]))
            mujoco.mjr_resizeOffscreen(*self._room, self._context)
        self._camera.fixedcamid = self._model.camera(camera).id
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(self._model, self._data, self._options, None, self._camera, everything, scene)
        area, image = mujoco.MjrRect(0, 0, width_px, height_px), np.empty((height_px, width_px, 3), np.uint8)
        depth = np.empty((height_px, width_px), np.float32)
        mujoco.mjr_render(area, scene, self._context)
        mujoco.mjr_readPixels(image, depth, area, self._context)
        image[depth >= 1.0] = SKY
        return image[::-1]

    def close(self) -> None:
        """Release the context."""
        self._context.free()
        self._egl.close()


class RayRenderer:
    """One ray for each of a few pixels: coarse, but independent of the machine's graphics."""

    name = "rays"

    def __init__(self, mujoco: ModuleType, model: MjModel, data: MjData) -> None:
        self._mujoco, self._model, self._data = mujoco, model, data
        self._colours = (model.geom_rgba[:, :3] * 255).astype(np.float32)
        self._groups = np.array([1, 1, 1, 0, 0, 0], dtype=np.uint8)

    def draw(self, camera: str, width_px: int, height_px: int) -> Image:
        """Return a picture of the present world, at most 160 pixels wide."""
        across = min(_RAYS_ACROSS, width_px)
        down = max(1, round(across * height_px / width_px))
        rays = self._rays(camera, across, down)
        count = across * down
        hit, distance = np.full(count, -1, np.int32), np.full(count, -1.0)
        normals, eye = np.zeros((count, 3)), self._data.camera(camera).xpos
        self._mujoco.mj_multiRay(
            self._model,
            self._data,
            eye,
            rays.ravel(),
            self._groups,
            1,
            -1,
            hit,
            distance,
            normals.ravel(),
            count,
            _FAR_M,
        )
        facing = np.abs((normals.reshape(-1, 3) * rays).sum(axis=1))
        light = (_AMBIENT + (1 - _AMBIENT) * facing)[:, None]
        image = np.where((hit >= 0)[:, None], self._colours[hit] * light, np.array(SKY, np.float32))
        return np.clip(image, 0, 255).astype(np.uint8).reshape(down, across, 3)

    def close(self) -> None:
        """Do nothing: it holds no resources."""

    def _rays(self, camera: str, across: int, down: int) -> NDArray[np.float64]:
        """Return a unit vector for each pixel; a camera of MuJoCo looks along its -z, with x to the right."""
        half = np.tan(np.radians(self._model.camera(camera).fovy[0]) / 2)
        right = (np.arange(across) + 0.5 - across / 2) * (2 * half / down)
        up = -(np.arange(down) + 0.5 - down / 2) * (2 * half / down)
        local = np.stack([*np.meshgrid(right, up), np.full((down, across), -1.0)], axis=-1).reshape(-1, 3)
        local /= np.linalg.norm(local, axis=1, keepdims=True)
        turned: NDArray[np.float64] = local @ self._data.camera(camera).xmat.reshape(3, 3).T
        return np.ascontiguousarray(turned)
