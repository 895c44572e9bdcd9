"""The emulated camera: the settings of its device rows, its faults, and its twin."""

from msgspec import Struct

from lbr.capability.twins import DeviceTwin
from lbr.simulation.faults import Faults, Probability


class CameraFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a camera. `stalled`: no picture. `slow`: two a second. `black`: with its cap. `garbage`: not a JPEG."""

    frozen: bool = False
    stalled: bool = False
    slow: bool = False
    black: bool = False
    garbage: Probability = 0.0


class CameraRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The place of a `camera` device row's camera, of the world's `cameras`. Empty: the one that its name ends with, or
    the first.
    """

    faults: CameraFaults = CameraFaults()
    mount: str = ""


TWIN = DeviceTwin(device="camera", row=CameraRow, entry="lbr.simulation.devices.camera.twin:CameraTwin")
