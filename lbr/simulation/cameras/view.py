"""The data of a picture from one instant of the world, in memory shared with the drawing process."""

import mmap
import os
import struct
from types import ModuleType
from zlib import crc32

import numpy as np

from lbr.simulation.bindings import MjData, MjModel
from lbr.simulation.model import PLACEABLE
from lbr.simulation.placing import resize

_HEADER = struct.Struct("<IQ")
_TRIES = 20


class SharedView:
    """The newest view only: a writer never waits, and a reader gets a complete one or None."""

    def __init__(self, size: int, descriptor: int | None = None) -> None:
        self.descriptor = os.memfd_create("world-view", os.MFD_CLOEXEC) if descriptor is None else descriptor
        self._end = _HEADER.size + size
        if descriptor is None:
            os.ftruncate(self.descriptor, self._end)
        self._memory = mmap.mmap(self.descriptor, self._end)

    def write(self, view: bytes, taken_ns: int) -> None:
        """Replace the view."""
        self._memory[: self._end] = _HEADER.pack(_sum(view, taken_ns), taken_ns) + view

    def read(self) -> tuple[int, bytes] | None:
        """Return the newest view and its time; None before the first, or if every attempt found one half written."""
        for _ in range(_TRIES):
            copy = self._memory[: self._end]
            checksum, taken_ns = _HEADER.unpack_from(copy)
            view = copy[_HEADER.size :]
            if taken_ns and checksum == _sum(view, taken_ns):
                return taken_ns, view
        return None

    def close(self) -> None:
        """Release the memory."""
        self._memory.close()
        os.close(self.descriptor)


def view_of(model: MjModel, data: MjData) -> bytes:
    """Return the positions of all bodies, and the sizes of placed ones."""
    sizes = [model.geom(name).size for name in _placeable(model)]
    return b"".join(part.tobytes() for part in (data.qpos, data.mocap_pos, data.mocap_quat, np.array(sizes)))


def show(mujoco: ModuleType, model: MjModel, data: MjData, view: bytes) -> None:
    """Restore the positions from a view."""
    values, at = np.frombuffer(view), 0
    for part in (data.qpos, data.mocap_pos, data.mocap_quat):
        part[...] = values[at : at + part.size].reshape(part.shape)
        at += part.size
    for name, half in zip(_placeable(model), values[at:].reshape(-1, 3), strict=True):
        resize(model, model.geom(name).id, model.body(name).id, tuple(half))
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)


def _placeable(model: MjModel) -> tuple[str, ...]:
    """Return the bodies that may change their size; only a room has them."""
    return PLACEABLE if model.nmocap and model.body(1).name == PLACEABLE[0] else ()


def _sum(view: bytes, taken_ns: int) -> int:
    return crc32(view, taken_ns & 0xFFFF_FFFF)
