"""An i2c bus held by one driver: opened by the address in its device row, with errors worded for people."""

import errno
import fcntl
import os
import re
from contextlib import suppress
from typing import NamedTuple

from lbr.capability.context import Device
from lbr.capability.tap import Tap
from lbr.drivers import access
from lbr.drivers.i2c_bus import Bus
from lbr.drivers.i2c_socket import SocketBus
from lbr.errors import DeviceError

UNANSWERED = frozenset({errno.EREMOTEIO, errno.ENXIO, errno.ENODEV, errno.ETIMEDOUT, errno.EIO})
"""The errors of adapters when no device answers. Each adapter has its own; none means anything more specific."""

_FIRST, _LAST = 0x08, 0x77
_I2C_TIMEOUT = 0x0702
_TIMEOUT_10MS = 5


class Place(NamedTuple):
    """The location of a device: bus `number`, or the socket `path`, and its own `address`."""

    number: int
    path: str
    address: int


class KernelBus(Bus):
    """A bus of this machine."""

    def __init__(self, number: int, tap: Tap) -> None:
        try:
            from smbus2 import SMBus
        except ImportError as err:
            raise DeviceError("the package smbus2 is not installed; pip install lbr brings it") from err
        self._bus = SMBus(number)
        if self._bus.fd is not None:
            with suppress(OSError):  # otherwise an adapter may wait a whole second
                fcntl.ioctl(self._bus.fd, _I2C_TIMEOUT, _TIMEOUT_10MS)
        super().__init__(tap)

    def transact(self, address: int, written: bytes, length: int) -> bytes:
        """Make the SMBus call for that many bytes."""
        bus, (register, *data) = self._bus, written
        match length, data:
            case 0, [value]:
                bus.write_byte_data(address, register, value)
            case 0, _:
                bus.write_i2c_block_data(address, register, data)
            case 1, _:
                return bytes((bus.read_byte_data(address, register),))
            case 2, _:
                return bus.read_word_data(address, register).to_bytes(2, "little")
            case _:
                return bytes(bus.read_i2c_block_data(address, register, length))
        return b""

    def close(self) -> None:
        """Close the device."""
        self._bus.close()


def open_bus(device: Device, default_address: int) -> tuple[Bus, int]:
    """Open the bus of a device row; return it with the device's address, `default_address` if the row has none."""
    place = locate(device, default_address)
    try:
        bus = SocketBus(place.path, device.tap) if place.path else KernelBus(place.number, device.tap)
    except OSError as err:
        raise DeviceError(_why_not(device, place, err), access.code_of(err)) from err
    return bus, place.address


def locate(device: Device, default_address: int) -> Place:
    """Return the location in a device row's address; raise DeviceError if it is malformed."""
    if found := _KERNEL.fullmatch(device.address):
        place = Place(int(found[1]), "", int(found[2], 0))
    elif found := _SOCKET.fullmatch(device.address):
        place = Place(-1, found[1], int(found[2], 0) if found[2] else default_address)
    else:
        complaint = f"device '{device.name}': address '{device.address}' is not one of i2c:BUS:ADDRESS (i2c:1:0x68)"
        raise DeviceError(f"{complaint}, unix:PATH, unix:PATH:ADDRESS; correct the device row")
    if not _FIRST <= place.address <= _LAST:
        complaint = f"device '{device.name}': i2c addresses are {_FIRST:#04x} to {_LAST:#04x}, not {place.address:#04x}"
        raise DeviceError(f"{complaint}; correct the address in the device row")
    return place


def unanswered(device: Device, address: int, err: OSError, what: str = "") -> DeviceError:
    """Return the DeviceError for a device on an open bus that fails or does not answer."""
    complaint = f"device '{device.name}' at {device.address}: {what or 'it'}"
    if err.errno in UNANSWERED:
        complaint = f"{complaint} does not answer at {address:#04x} ({_cause(err)}); check its power and wiring"
    else:
        complaint = f"{complaint} at {address:#04x} cannot be used ({_cause(err)})"
    return DeviceError(f"{complaint}; {_look(device)}")


def _why_not(device: Device, place: Place, err: OSError) -> str:
    if isinstance(err, DeviceError):
        return f"device '{device.name}': {err}"
    if place.path:
        complaint = f"device '{device.name}': no process serves {place.path} ({_cause(err)})"
        return f"{complaint}; start what stands for the device there, or correct the address in the device row"
    complaint = f"device '{device.name}' at {device.address}: /dev/i2c-{place.number}"
    match err.errno:
        case errno.ENOENT | errno.ENXIO | errno.ENODEV:
            return f"{complaint} is missing; switch i2c on (on a Pi: raspi-config), or correct the row; see lbr doctor"
        case errno.EACCES | errno.EPERM:
            return f"{complaint} {access.refused(f'/dev/i2c-{place.number}', 'i2c')}"
        case _:
            return f"{complaint} cannot be opened ({_cause(err)}); see lbr doctor"


def _look(device: Device) -> str:
    if found := _KERNEL.fullmatch(device.address):
        return f"'i2cdetect -y {found[1]}' shows what is there, 'lbr doctor' what is missing here"
    return "'lbr status' shows whether what serves it is running"


def _cause(err: OSError) -> str:
    return os.strerror(err.errno) if err.errno else str(err)


_KERNEL = re.compile(r"i2c:(\d{1,3}):(0[xX][0-9a-fA-F]{1,4}|[1-9]\d{0,3}|0)")
_SOCKET = re.compile(r"unix:(.+?)(?::(0[xX][0-9a-fA-F]{1,4}|[1-9]\d{0,3}))?")
