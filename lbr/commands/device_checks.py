"""The checks of `lbr doctor` on device rows, by their address: a path, an i2c bus, sound, a camera."""

import contextlib
import ctypes.util
import grp
import importlib.util
import os
import re
import shutil
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

from lbr import plugins
from lbr.capability import registry, twins
from lbr.capability.context import Device
from lbr.capability.kind import KindError
from lbr.capability.twins import TwinError
from lbr.commands.finding import Finding, Level
from lbr.database.rows import DeviceRow
from lbr.drivers import access
from lbr.drivers.gamepad.nodes import path_of
from lbr.drivers.infrared import decoders
from lbr.drivers.serial_line import resolve
from lbr.errors import DeviceError

Judgement = tuple[Level, str, str]
"""Level, text and cure."""

NOWHERE = Path("/nowhere")
"""Installed kinds are enough to know a device's line: capability files are not needed."""
USB_SERIAL = Path("/sys/bus/usb-serial/devices")
TUNED_MS = "1"
NUMBERED = re.compile(r"/dev/(?:input/)?(ttyACM|ttyUSB|video|event)\d+")
BY_NAME = {
    **dict.fromkeys(("ttyACM", "ttyUSB"), "/dev/serial/by-id"),
    "video": "/dev/v4l/by-id",
    "event": "/dev/input/by-id",
}
"""The places of permanent names for devices, by the text before the number."""
SOUND_CARDS = Path("/proc/asound/cards")
LOOKS = {"camera": "v4l2-ctl --list-devices", "infrared": "ir-keytable", "gamepad": "lbr devices"}
"""The command that finds a device, by its type; for most others it is `ls /dev/serial/by-id`."""


def device(robot: str, row: DeviceRow) -> Finding:
    """Report the state of one device row."""
    scheme, _, rest = row.address.partition(":")
    level, text, do = _schemes().get(scheme, _file)(row, rest)
    if level == "hint":
        text += f"; robot '{robot}' runs without it, and simulation does not need it"
    return Finding(about=f"device '{row.name}'", level=level, text=text, do=do)


def numbered(row: DeviceRow) -> Iterator[Finding]:
    """Warn of a numbered address: it may belong to another device after each replug and each start."""
    if found := NUMBERED.fullmatch(row.address):
        text = f"{row.address} is a number that another device may have after a replug or a restart"
        do = f"ls -l {BY_NAME[found[1]]}, and write the name of yours into the device row's address"
        yield Finding(about=f"address of '{row.name}'", level="hint", text=text, do=do)


def latency(row: DeviceRow) -> Iterator[Finding]:
    """Check how long a USB adapter delays answers, for devices that are asked many times a second."""
    if _line(row.type) != "polled":
        return
    try:
        timer = USB_SERIAL / Path(_resolved(row)).resolve().name / "latency_timer"
    except DeviceError:
        return
    if not timer.exists():
        return
    about, held = f"latency of '{row.name}'", timer.read_text().strip()
    if held == TUNED_MS:
        yield Finding(about=about, level="good", text=f"its adapter holds answers back for {held} ms")
    else:
        text = f"its adapter holds every answer back for {held} ms: positions come late and seldom"
        do = f"echo {TUNED_MS} | sudo tee {timer}; 'lbr service install' has it so at every plug-in"
        yield Finding(about=about, level="hint", text=text, do=do)


def speech() -> Iterator[Finding]:
    """Check the engine that turns text into sound."""
    if ctypes.util.find_library("espeak-ng") or ctypes.util.find_library("espeak"):
        yield Finding(about="speech", level="good", text="espeak-ng is installed")
    else:
        text = "no speech engine: the robot stays silent"
        yield Finding(about="speech", level="hint", text=text, do="sudo apt install espeak-ng")


def emulated() -> Iterator[Finding]:
    """Report packages whose twins cannot be used; robots without these devices run."""
    wrong = list(twins.refused())
    for device_type in twins.names():
        try:
            twins.find(device_type)
        except TwinError as err:
            wrong.append(str(err))
    for text in dict.fromkeys(wrong):
        yield Finding(about="twins of devices", level="hint", text=text, do="pip list, then pip uninstall PACKAGE")


def of_packages() -> Iterator[Finding]:
    """Report unusable components, kinds, commands and faces of packages, even if no row names them."""
    do = "pip list, then pip uninstall PACKAGE"
    for why in plugins.broken():
        yield Finding(about="components of packages", level="hint", text=why, do=do)
    for point in plugins.every("kinds"):
        try:
            registry.declared(point)
        except KindError as err:
            yield Finding(about="kinds of packages", level="hint", text=str(err), do=do)
    for point in (*plugins.every("commands"), *plugins.every("faces"), *plugins.every("ports")):
        if point.refusal:
            about = f"{point.field} of packages"
            yield Finding(about=about, level="hint", text=f"{point.label}: {point.refusal}", do=do)


def _schemes() -> dict[str, Callable[[DeviceRow, str], Judgement]]:
    return {
        "sim": lambda _row, _rest: ("good", "emulated", ""),
        "usb": _serial,
        "by-id": _serial,
        "alsa": _sound,
        "csi": _pi_camera,
        "i2c": _i2c,
        "input": _gamepad,
        "unix": lambda _row, rest: _at(Path(rest), "lbr status"),
    }


def _serial(row: DeviceRow, _rest: str) -> Judgement:
    if not _line(row.type):
        return "good", f"'{row.address}' is looked for when the robot starts, not now", ""
    try:
        return _at(Path(_resolved(row)), "ls /dev/serial/by-id")
    except DeviceError as err:
        return "hint", str(err), "ls -l /dev/serial/by-id"


@cache
def _line(device_type: str) -> str:
    """Return the line of a type of device, by the kinds that drive it; broken kinds are skipped."""
    for name in registry.names(NOWHERE):
        with contextlib.suppress(KindError):
            kind = registry.find(name, NOWHERE)
            if kind.device is not None and kind.device.type == device_type:
                return kind.device.line
    return ""


def _resolved(row: DeviceRow) -> str:
    return resolve(Device(row.name, row.type, row.address, {}))


def _file(row: DeviceRow, _rest: str) -> Judgement:
    level, text, do = _at(Path(row.address), LOOKS.get(row.type, "ls /dev/serial/by-id"))
    found = decoders.of(row.address) if level == "good" and row.type == "infrared" else None
    if lacks := found.lacks() if found is not None else "":
        said, _, command = lacks.partition(": ")
        return "bad", f"{row.address} {said}, so no beam is heard", command
    return level, text, do


def _gamepad(row: DeviceRow, _rest: str) -> Judgement:
    return _at(Path(path_of(row.address) or row.address), LOOKS["gamepad"])


def _i2c(_row: DeviceRow, rest: str) -> Judgement:
    return _at(Path(f"/dev/i2c-{rest.partition(':')[0]}"), "sudo modprobe i2c-dev; ls /dev/i2c-*")


def _at(path: Path, look: str) -> Judgement:
    if not path.exists():
        return "hint", f"{path} is not there: plug it in", look
    if not os.access(path, os.R_OK | os.W_OK):
        if access.is_settling(str(path)):
            return "bad", f"{path} may not be opened yet: udev may still be setting its group", "lbr doctor"
        return "bad", f"{path} may not be opened", join_group(path)
    return "good", str(path), ""


def _sound(_row: DeviceRow, _rest: str) -> Judgement:
    cards = SOUND_CARDS.read_text() if SOUND_CARDS.exists() else ""
    if "[" not in cards:
        return "hint", "this machine has no sound card", "aplay -l"
    if shutil.which("aplay") is None:
        return "hint", "the program aplay is missing", "sudo apt install alsa-utils"
    return "good", cards.splitlines()[0].strip(), ""


def _pi_camera(_row: DeviceRow, _rest: str) -> Judgement:
    if importlib.util.find_spec("picamera2") is not None:
        return "good", "picamera2 is installed", ""
    do = "sudo apt install python3-picamera2; python3 -m venv --system-site-packages .venv"
    return "hint", "picamera2 is not in this Python: it comes with Raspberry Pi OS", do


def join_group(path: Path) -> str:
    """Return the command that gives this user access to a file, through its group."""
    with contextlib.suppress(KeyError, OSError):
        return f"sudo usermod -aG {grp.getgrgid(path.stat().st_gid).gr_name} $USER, then log in again"
    return f"ls -l {path}"
