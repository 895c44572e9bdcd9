"""Opens the camera of a device row with the source for its address."""

from lbr.capability.context import Device
from lbr.drivers.camera import CameraSettings
from lbr.drivers.camera.picture import Source
from lbr.errors import DeviceError


def open_source(device: Device, settings: CameraSettings) -> Source:
    """Open the camera of a device row with its settings; takes up to a second or so."""
    address = device.address
    if settings.rotation_deg and not address.startswith("csi:"):
        raise DeviceError(
            f"device '{device.name}': only a camera at csi:N can turn its picture; leave out rotation_deg"
        )
    if address.startswith("unix:"):
        from lbr.drivers.camera.stream import StreamSource  # noqa: PLC0415 - one of them is used

        return StreamSource(device, settings)
    if address.startswith("csi:"):
        from lbr.drivers.camera.csi import CsiSource  # noqa: PLC0415

        return CsiSource(device, settings)
    if address.startswith("/dev/"):
        from lbr.drivers.camera.v4l2 import V4l2Source  # noqa: PLC0415

        return V4l2Source(device, settings)
    raise DeviceError(
        f"device '{device.name}': address '{address}' is not one of /dev/videoN, /dev/v4l/by-id/NAME, csi:N, unix:PATH"
    )
