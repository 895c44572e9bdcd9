"""Where the unit is: Phidgets' own library for one on USB, or what stands for both at a socket.

Addresses: `usb:` for the only unit, `usb:SERIAL` for one of several, `unix:PATH`.
"""

# ruff: noqa: N802, N803 - the library's own names

import re
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

from lbr.capability.context import Device
from lbr.drivers.phidget_spatial.emulated import EmulatedSpatial
from lbr.errors import DeviceError

OnData = Callable[[Any, Sequence[float], Sequence[float], Sequence[float], float], None]


class Spatial(Protocol):
    """The calls of `Phidget22.Devices.Spatial.Spatial` that are used here, by their own names."""

    def setOnSpatialDataHandler(self, handler: OnData | None) -> None:
        """Have a function called with every sample, on a thread of the library's."""

    def setOnDetachHandler(self, handler: Callable[[Any], None] | None) -> None:
        """Have a function called when the unit is gone."""

    def openWaitForAttachment(self, timeout: int) -> None:
        """Wait up to `timeout` milliseconds for the unit."""

    def setDataInterval(self, DataInterval: int) -> None:
        """Have a sample at this interval, in milliseconds; forgotten when it is plugged in again."""

    def getDeviceName(self) -> str:
        """Return what it is."""

    def zeroGyro(self) -> None:
        """Take the gyro's zero, for about two seconds."""

    def close(self) -> None:
        """Close the device."""


class Opened(NamedTuple):
    """A unit that is not attached yet, and what its calls raise."""

    unit: Spatial
    errors: tuple[type[Exception], ...]


def find(device: Device) -> Opened:
    """Return the unit that a device row means; raise DeviceError saying what is missing."""
    if device.address.startswith("unix:"):
        return Opened(EmulatedSpatial(device.address.removeprefix("unix:")), (OSError,))
    found = _USB.fullmatch(device.address)
    if found is None:
        said = f"device '{device.name}': address '{device.address}' is not one of usb:, usb:SERIAL, unix:PATH"
        raise DeviceError(f"{said}; correct the device row")
    try:
        from Phidget22.Devices.Spatial import Spatial as OnUsb
        from Phidget22.PhidgetException import PhidgetException

        unit = OnUsb()  # loads what is native
    except (ImportError, OSError) as err:
        said = f"Phidgets' library cannot be used ({err})"
        raise DeviceError(f"{said}; install lbr with its extra 'phidgets', and the system's libusb-1.0") from err
    if found[1]:
        unit.setDeviceSerialNumber(int(found[1]))
    return Opened(unit, (PhidgetException, OSError))


_USB = re.compile(r"usb:(\d{1,10})?")
