"""The emulated camera: what its device rows may set, what can go wrong with it, and which twin it has."""

from msgspec import Struct

from lbr.capability.twins import DeviceTwin
from lbr.simulation.faults import Faults, Probability


class CameraFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a camera.

    `frozen`: the same picture for ever, always new. `stalled`: no picture comes. `slow`: two come each second.
    `black`: its cap is on. `garbage`: a picture is no JPEG.
    """

    frozen: bool = False
    stalled: bool = False
    slow: bool = False
    black: bool = False
    garbage: Probability = 0.0


class CameraRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where a `camera` device row's camera sits: a name of the world's setting `cameras`.

    Empty: the one that the device's name ends with, or else the first.
    """

    faults: CameraFaults = CameraFaults()
    mount: str = ""


TWIN = DeviceTwin(device="camera", row=CameraRow, entry="lbr.simulation.devices.camera.twin:CameraTwin")
