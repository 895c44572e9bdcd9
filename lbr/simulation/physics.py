"""MuJoCo, as the worlds use it."""

import importlib
import os
from typing import Any

from lbr.errors import LbrError

os.environ.pop("MUJOCO_GL", None)  # the choice of a renderer that is not installed would fail the import
try:
    mujoco: Any = importlib.import_module("mujoco")  # its bindings carry no types
except ImportError as err:
    raise LbrError(f"the simulated world needs MuJoCo ({err}); install lbr with its extra 'sim'") from err
