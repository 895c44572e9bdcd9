"""The devices plugged in here: serial adapters, i2c buses, cameras, receivers, gamepads, input nodes. Opens nothing."""

import os
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from msgspec import Struct
from serial.tools import list_ports

from lbr.drivers.gamepad import nodes
from lbr.errors import InputError
from lbr.messages.rows import short

Place = Literal["serial", "i2c", "video", "lirc", "gamepad", "input"]
DEV, SYS = Path("/dev"), Path("/sys")


class End(Struct, frozen=True, kw_only=True):
    """One place for a device: `address` as in a device row, `path` the kernel's present node.

    `name` and `serial` come from its adapter or the kernel, and may be empty.
    """

    place: Place
    address: str
    path: str
    name: str = ""
    serial: str = ""


def ends(dev: Path = DEV, sys: Path = SYS) -> list[End]:
    """Return all present ends, each once, by a permanent name if it has one."""
    return [*_serial(dev), *_buses(dev), *_named("video", dev, sys), *_named("lirc", dev, sys), *_inputs(dev, sys)]


def named(text: str) -> End:
    """Return the end that a person names: a tty's path, `i2c:BUS`, or `unix:PATH` of an i2c bus; else InputError."""
    if not text.startswith(("/", "i2c:", "unix:/")):
        raise InputError(f"--port '{short(text)}' is not one of a path (/dev/...), i2c:BUS, unix:/PATH")
    if text.startswith(("i2c:", "unix:")):
        return End(place="i2c", address=text, path=text)
    return End(place="serial", address=text, path=os.path.realpath(text), name=Path(text).name)


def stable(names: list[Path], count: Counter[str], vendor: str, places: list[Path], path: str) -> str:
    """Return the permanent name of a tty: by its device if no other is the same, otherwise by its USB port."""
    if names and count[vendor] < 2:
        return str(names[0])
    return str(places[0]) if places else str(names[0]) if names else path


def _serial(dev: Path) -> Iterator[End]:
    """Yield USB adapters. A machine's own lines may be its console, and are only used if a person names them."""
    links, places = _links(dev / "serial/by-id"), _links(dev / "serial/by-path")
    usb = (
        {os.path.realpath(port.device): port for port in list_ports.comports() if port.vid is not None}
        if dev == DEV
        else {}
    )
    nodes = {node for node in (*links, *places, *usb) if node}
    alike = Counter(f"{port.vid}:{port.pid}:{port.serial_number}:{port.interface}" for port in usb.values())
    for node in sorted(nodes):
        port = usb.get(node)
        key = f"{port.vid}:{port.pid}:{port.serial_number}:{port.interface}" if port is not None else ""
        name = " ".join(filter(None, (port.manufacturer, port.product))) if port is not None else ""
        address = stable(links.get(node, []), alike, key, places.get(node, []), node)
        serial = (port.serial_number or "") if port is not None else ""
        yield End(place="serial", address=address, path=node, name=name or Path(address).name, serial=serial)


def _buses(dev: Path) -> Iterator[End]:
    for node in sorted(dev.glob("i2c-*")):
        number = node.name.removeprefix("i2c-")
        if number.isdigit():
            adapter = _read(SYS / "class/i2c-dev" / node.name / "name")
            yield End(place="i2c", address=f"i2c:{int(number)}", path=str(node), name=adapter)


def _named(place: Literal["video", "lirc"], dev: Path, sys: Path) -> Iterator[End]:
    """Yield the nodes of cameras and receivers; only the first node of a camera has its pictures."""
    folder = sys / ("class/video4linux" if place == "video" else "class/lirc")
    links = _links(dev / "v4l/by-id") if place == "video" else {}
    paths = _links(dev / "v4l/by-path") if place == "video" else {}
    for entry in sorted(folder.glob("video*" if place == "video" else "lirc*"), key=lambda one: _number(one.name)):
        node = dev / entry.name
        if place == "video" and _read(entry / "index") not in {"", "0"}:
            continue
        name = _read(entry / "name") if place == "video" else _receiver(entry)
        same = links.get(os.path.realpath(node), []) or paths.get(os.path.realpath(node), [])
        yield End(place=place, address=str(same[0] if same else node), path=str(node), name=name)


def _receiver(entry: Path) -> str:
    """Return the name of a receiver, which its input device has."""
    found = [_read(one / "name") for one in sorted((entry / "device").glob("input*"))]
    return next(filter(None, found), entry.name)


def _inputs(dev: Path, sys: Path) -> Iterator[End]:
    """Yield gamepads, including wireless ones without a name from udev; of other inputs, only those plugged in."""
    links = _links(dev / "input/by-id")
    pads = {os.path.realpath(dev / "input" / one.node): one for one in nodes.gamepads(sys / "class/input")}
    for node, pad in pads.items():
        names = links.get(node, [])
        yield End(place="gamepad", address=str(names[0]) if names else pad.address, path=node, name=pad.name)
    for node, names in sorted(links.items()):
        if "event" in Path(node).name and node not in pads:
            yield End(place="input", address=str(names[0]), path=node, name=names[0].name)


def _links(folder: Path) -> dict[str, list[Path]]:
    """Return the links of a folder by their target nodes."""
    links: dict[str, list[Path]] = {}
    try:
        entries = sorted(folder.iterdir())
    except OSError:
        return links
    for link in entries:
        if link.exists():
            links.setdefault(os.path.realpath(link), []).append(link)
    return links


def _number(name: str) -> int:
    digits = re.sub(r"\D", "", name)
    return int(digits) if digits else 0


def _read(path: Path) -> str:
    try:
        return path.read_text(errors="replace").strip()
    except OSError:
        return ""
