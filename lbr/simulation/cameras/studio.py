"""The drawing of pictures: the world of a moment ago, as a device with its faults shows it."""

import ctypes
import importlib
import io
import os
from contextlib import suppress
from types import ModuleType

import numpy as np

from lbr.errors import LbrError
from lbr.simulation.bindings import MjModel
from lbr.simulation.cameras.renderers import GlRenderer, Image, RayRenderer, Renderer
from lbr.simulation.cameras.view import SharedView, show
from lbr.simulation.devices.camera import CameraFaults
from lbr.simulation.physics import mujoco

REST_S = 60.0
"""The renderer is released after this long without a picture."""
_QUALITY = 75
_GARBAGE_BYTES = 2000


class Studio:
    """Draws one picture at a time, of a model of its own; raises LbrError if no renderer works here."""

    def __init__(self, model: MjModel, view: SharedView, *, use_gl: bool) -> None:
        try:
            self._pillow: ModuleType = importlib.import_module("PIL.Image")
        except ImportError as err:
            raise LbrError(f"pictures need Pillow ({err}); install lbr with its extra 'sim'") from err
        self.note = ""
        self._model = model
        self._data = mujoco.MjData(self._model)
        self._view = view
        self._shown_ns = 0
        self._shown = b""
        self._drawn: dict[tuple[str, tuple[int, int]], bytes] = {}
        self._frozen: dict[str, bytes] = {}
        self._use_gl = use_gl
        self._used_s: float | None = None
        self._renderer: Renderer | None = self._chosen()
        self.renderer = self._renderer.name

    @property
    def holds_renderer(self) -> bool:
        """Return whether there is a renderer to release."""
        return self._renderer is not None

    def newest_ns(self) -> int:
        """Load the newest view, and return its time."""
        newest = self._view.read()
        if newest is not None and newest[0] != self._shown_ns:
            self._shown_ns = newest[0]
            if newest[1] != self._shown:
                self._shown = newest[1]
                self._drawn.clear()
                show(mujoco, self._model, self._data, newest[1])
        return self._shown_ns

    def picture(self, device: str, mount: str, size: tuple[int, int], faults: CameraFaults) -> bytes:
        """Return a device's present picture: a JPEG, unless a fault spoils it."""
        if faults.garbage and np.random.random() < faults.garbage:
            return os.urandom(_GARBAGE_BYTES)
        if not faults.frozen:
            self._frozen.pop(device, None)
        elif device in self._frozen:
            return self._frozen[device]
        jpeg = self._jpeg(np.zeros((1, 1, 3), np.uint8), size) if faults.black else self._seen(mount, size)
        if faults.frozen:
            self._frozen[device] = jpeg
        return jpeg

    def _seen(self, mount: str, size: tuple[int, int]) -> bytes:
        """Return the view from a mount; while nothing has moved it is drawn once."""
        if (mount, size) not in self._drawn:
            self._drawn[mount, size] = self._jpeg(self._image(mount, size), size)
            self._used_s = None
        return self._drawn[mount, size]

    def _image(self, mount: str, size: tuple[int, int]) -> Image:
        if self._renderer is None:
            self._renderer = self._chosen()
        return self._renderer.draw(mount, *size)

    def rest(self, now: float, *, watched: bool) -> None:
        """Release the renderer after a minute without pictures and viewers; the next picture starts it again."""
        if watched or self._used_s is None:
            self._used_s = now
        elif now - self._used_s >= REST_S:
            self.close()

    def close(self) -> None:
        """Close the renderer."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None
            with suppress(AttributeError):  # a C library that is not glibc
                ctypes.CDLL(None).malloc_trim(0)

    def _chosen(self) -> Renderer:
        if self._use_gl:
            try:
                return GlRenderer(mujoco, self._model, self._data)
            except (LbrError, mujoco.FatalError) as err:
                self.note = str(err)
        else:
            self.note = "OpenGL broke down on this machine"
        return RayRenderer(mujoco, self._model, self._data)

    def _jpeg(self, image: Image, size: tuple[int, int]) -> bytes:
        drawn = self._pillow.fromarray(image)
        if drawn.size != size:
            drawn = drawn.resize(size, self._pillow.Resampling.BILINEAR)
        out = io.BytesIO()
        drawn.save(out, "JPEG", quality=_QUALITY)
        return out.getvalue()
