"""The kernel's remote control input as an open file: /dev/lircN, an input event device, or an emulated one."""

import errno
import struct
from contextlib import ExitStack
from pathlib import Path

from lbr.capability.context import Device
from lbr.drivers.infrared import InfraredSettings, decoders, records
from lbr.drivers.infrared.records import Scancode
from lbr.drivers.input_node import InputNode
from lbr.errors import DeviceError

LIRC_SET_REC_MODE, LIRC_MODE_SCANCODE = 0x40046912, 8


class Receiver:
    """An open receiver; a DeviceError names the device row, the path and the cure when it is missing or goes away."""

    def __init__(self, device: Device, settings: InfraredSettings) -> None:
        self._address = device.address
        if not device.address.startswith("/"):
            what = "is not a path; write /dev/lirc0 or /dev/input/by-path/… into the device row"
            raise DeviceError(f"device '{device.name}' at {device.address} {what}")
        events = _sends_events(device.address, settings)
        self._node = InputNode(device, device.address, records.parser(events=events))
        with ExitStack() as failed:
            failed.callback(self.close)
            self._node.claim() if events else self._prepare_scancodes()
            self._refuse_without_decoder(settings)
            failed.pop_all()

    def poll(self) -> list[Scancode]:
        """Return the scancodes received since the last call."""
        return self._node.poll()

    def close(self) -> None:
        """Close the device; never fails."""
        self._node.close()

    def _prepare_scancodes(self) -> None:
        """Ask for decoded codes instead of pulses."""
        try:
            self._node.order(LIRC_SET_REC_MODE, struct.pack("=I", LIRC_MODE_SCANCODE))
        except OSError as err:
            if err.errno == errno.EINVAL:
                raise self._node.error("decodes nothing; switch its protocol on with ir-keytable -p sony") from err
            if err.errno != errno.ENOTTY:
                raise self._node.error(f"cannot be set up: {err.strerror}") from err

    def _refuse_without_decoder(self, settings: InfraredSettings) -> None:
        """Refuse a receiver without a wanted decoder: the kernel would open it, but deliver nothing."""
        enabled = decoders.of(self._address)
        if lacks := enabled.lacks(settings.protocols) if enabled is not None else "":
            raise self._node.error(lacks)


def _sends_events(address: str, settings: InfraredSettings) -> bool:
    if settings.records == "auto":
        return any(path.startswith("/dev/input/") for path in (address, str(Path(address).resolve())))
    return settings.records == "events"
