"""The unit of an address: on USB by Phidgets' own library, or emulated at a socket.

Addresses: `usb:` for the only unit, `usb:SERIAL` for one of several, `unix:PATH`.
"""

# ruff: noqa: N802, N803 - the library's own names

import re
from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

from lbr.capability.context import Device
from lbr.drivers.phidget_spatial.emulated import EmulatedSpatial
from lbr.errors import DeviceError

OnData = Callable[[object, Sequence[float], Sequence[float], Sequence[float], float], None]


class Spatial(Protocol):
    """The calls of `Phidget22.Devices.Spatial.Spatial` used here, by their own names."""

    def setOnSpatialDataHandler(self, handler: OnData | None) -> None:
        """Set the function that is called with every sample, on a thread of the library."""

    def setOnDetachHandler(self, handler: Callable[[object], None] | None) -> None:
        """Set the function that is called when the unit is gone."""

    def openWaitForAttachment(self, timeout: int) -> None:
        """Wait up to `timeout` milliseconds for the unit."""

    def setDataInterval(self, DataInterval: int) -> None:
        """Set the interval between samples, in milliseconds; it is lost when the unit is plugged in again."""

    def zeroGyro(self) -> None:
        """Take the gyro's zero, for about two seconds."""

    def close(self) -> None:
        """Close the device."""


class Opened(NamedTuple):
    """A unit that is not attached yet, and the errors of its calls."""

    unit: Spatial
    errors: tuple[type[Exception], ...]


def find(device: Device) -> Opened:
    """Return the unit of a device row; raise DeviceError if the address is wrong or the library is missing."""
    if device.address.startswith("unix:"):
        return Opened(EmulatedSpatial(device.address.removeprefix("unix:")), (OSError,))
    address = _USB.fullmatch(device.address)
    if address is None:
        complaint = f"device '{device.name}': address '{device.address}' is not one of usb:, usb:SERIAL, unix:PATH"
        raise DeviceError(f"{complaint}; correct the device row")
    try:
        from Phidget22.Devices.Spatial import Spatial as OnUsb
        from Phidget22.PhidgetException import PhidgetException

        unit = OnUsb()  # loads what is native
    except (ImportError, OSError) as err:
        complaint = f"Phidgets' library cannot be used ({err})"
        raise DeviceError(f"{complaint}; install lbr with its extra 'phidgets', and the system's libusb-1.0") from err
    if address[1]:
        unit.setDeviceSerialNumber(int(address[1]))
    return Opened(unit, (PhidgetException, OSError))


_USB = re.compile(r"usb:(\d{1,10})?")
