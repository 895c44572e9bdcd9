"""MuJoCo, for the worlds."""

import importlib
import os
from types import ModuleType

import numpy as np

from lbr.errors import LbrError
from lbr.simulation.bindings import MjModel

os.environ.pop("MUJOCO_GL", None)  # a renderer that is not installed would fail the import
try:
    mujoco: ModuleType = importlib.import_module("mujoco")  # its bindings carry no types
except ImportError as err:
    if isinstance(err.__cause__, KeyboardInterrupt):  # the import of the bindings was interrupted
        raise KeyboardInterrupt from None
    raise LbrError(f"the simulated world needs MuJoCo ({err}): pip install 'lbr[sim]'") from err

_FILE = "model.mjb"


def packed(model: MjModel) -> bytes:
    """Return a model as bytes, for another process of this version."""
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


def unpacked(data: bytes) -> MjModel:
    """Return the model from such bytes."""
    return mujoco.MjModel.from_binary_path(_FILE, {_FILE: data})
