"""Emulated devices behind USB devices that are played to the kernel, and the names that udev gives them."""

import os
import pwd
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Generic, TypeVar

from lbr.testing.device import Plugged, plugged
from tests.support import tap
from tests.support.usb.descriptors import Identity
from tests.support.usb.device import Function, Played
from tests.support.usb.i2c_function import TinyI2c
from tests.support.usb.serial_function import CdcAcm, Ftdi, SerialFunction

BY_ID = Path("/dev/serial/by-id")
ADAPTORS = Path("/sys/class/i2c-dev")
NAMED_S = 60.0
"""The kernel asks a new device a dozen times before udev names it: a second, and much longer on an emulated processor."""
F = TypeVar("F", bound=Function)

ROBOTEQ = Identity(0x20D2, 0x1000, "Roboteq", "Motor Controller", device_class=(2, 0, 0))
ARDUINO = Identity(0x2341, 0x0043, "Arduino (www.arduino.cc)", "", "75433313637351E0A1B2", 0x0001, (2, 0, 0))
USB2AX = Identity(0x16D0, 0x06A7, "Xevelabs", "USB2AX", "64138323832351A0E061", device_class=(2, 0, 0))
RIOX = Identity(0x20D2, 0x1216, "Roboteq", "RIOX", device_class=(2, 0, 0))
ROBOCLAW = Identity(0x03EB, 0x2404, "Basicmicro", "USB Roboclaw 2x15A", device_class=(2, 0, 0))
CH343 = Identity(0x1A86, 0x55D3, "1a86", "USB Single Serial", "FOLLOWER", device_class=(2, 0, 0))
"""With the serial number that the SO-101's row has for an example."""
FT232R = Identity(0x0403, 0x6001, "FTDI", "FT232R USB UART", "A50285BI", 0x0600)


class Rig(Generic[F]):
    """An emulated device, its USB function, and its cable."""

    def __init__(self, twin: Plugged, function: F, cable: Played) -> None:
        self.twin = twin
        self.function = function
        self.cable = cable


@contextmanager
def on_line(
    type_: str, folder: Path, made: Callable[[Path, Identity], SerialFunction], identity: Identity, **options: Any
) -> Iterator[Rig[SerialFunction]]:
    """Plug in an emulated device of a serial line; waits until udev has named it."""
    with plugged(type_, folder, name=f"{type_}-{identity.serial}", **options) as twin:
        line = Path(twin.device.address)
        until(line.exists, f"the emulated {type_}'s line")
        function = made(line, identity)
        try:
            with Played(function) as cable:
                until(lambda: by_id(identity).exists(), f"a name for the {type_}: {by_id(identity)}", NAMED_S)
                yield Rig(twin, function, cable)
        finally:
            function.finish()


@contextmanager
def adaptor(
    folder: Path, type_: str, *, heard: list[bytes] | None = None, **options: Any
) -> Iterator[tuple[int, TinyI2c, Played]]:
    """Plug in an I2C adaptor with an emulated device on its bus; give its number, its function and its cable.

    `heard` takes the transactions that come to the device.
    """
    before = _adaptors()
    with plugged(type_, folder, name=type_, scheme="unix:", **options) as twin:
        if heard is not None:
            tap.of(twin, heard)
        bus = folder / type_
        until(bus.exists, "the emulated bus")
        function = TinyI2c(bus)
        with Played(function) as cable:
            until(lambda: _adaptors() - before, "an adaptor", NAMED_S)
            (name,) = _adaptors() - before
            until(lambda: Path(f"/dev/{name}").exists(), "its node", NAMED_S)
            yield int(name.removeprefix("i2c-")), function, cable


def _adaptors() -> set[str]:
    return {one.name for one in ADAPTORS.iterdir()} if ADAPTORS.exists() else set()


def by_id(identity: Identity) -> Path:
    """Return the name that udev gives a serial line by its strings, or by its ids where it has none."""
    words = (
        identity.manufacturer or f"{identity.vendor:04x}",
        identity.name or f"{identity.product:04x}",
        identity.serial,
    )
    plain = "_".join("".join(c if c.isalnum() or c in "#+-.:=@_" else "_" for c in word) for word in words if word)
    port = "-port0" if identity.vendor == FT232R.vendor else ""
    return BY_ID / f"usb-{plain}-if00{port}"


def until(look: Callable[[], object], what: str, within_s: float = 8.0, *, every_s: float = 0.01) -> float:
    """Wait until something is so; return after how long. Fail with what it is if that takes too long."""
    began = time.monotonic()
    while not look():
        if time.monotonic() > began + within_s:
            raise AssertionError(f"not within {within_s:g} s: {what}")
        time.sleep(every_s)
    return time.monotonic() - began


def service_user() -> str:
    """Return the user that the service of this machine runs as; nothing if `lbr service install` was never typed here."""
    try:
        return pwd.getpwnam("lbr").pw_name
    except KeyError:
        return ""


def given_to(user: str, folder: Path) -> Path:
    """Give a folder and what is in it to a user."""
    known = pwd.getpwnam(user)
    for place in (folder, *folder.rglob("*")):
        os.chown(place, known.pw_uid, known.pw_gid, follow_symlinks=False)
    return folder


def as_user(user: str) -> tuple[str, ...]:
    """Return what to put before a command so that it runs as a user with that user's groups."""
    return ("setpriv", f"--reuid={user}", f"--regid={user}", "--init-groups", "--")


__all__ = [
    "ARDUINO",
    "CH343",
    "FT232R",
    "RIOX",
    "ROBOCLAW",
    "ROBOTEQ",
    "USB2AX",
    "CdcAcm",
    "Ftdi",
    "Rig",
    "adaptor",
    "as_user",
    "by_id",
    "given_to",
    "on_line",
    "service_user",
    "until",
]
