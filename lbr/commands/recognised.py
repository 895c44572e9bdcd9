"""Identifies the devices at all ends at the same time; ends in use by a robot or program are reported unopened."""

import os
import time
from collections.abc import Collection, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import msgspec
from msgspec import Struct

from lbr.capability import recognition, registry
from lbr.capability.context import Device
from lbr.capability.kind import Kind, KindError
from lbr.commands.attached import End, Place
from lbr.commands.device_checks import join_group
from lbr.database.rows import DeviceRow
from lbr.drivers import recognising
from lbr.drivers.gamepad.nodes import ANYWHERE, path_of
from lbr.drivers.recognising import Found, Known
from lbr.drivers.serial_line import holder, resolve
from lbr.errors import DeviceError
from lbr.messages.schema import JsonObject

AT_ONCE = 16
INPUT_TEXT = "an input device; no driver here takes it"


class Attached(Struct, frozen=True, kw_only=True):
    """The device at one end: its `type`, and its description `what`, empty if unknown; `text` is the reason.

    `row` is its existing device row, `settings` are those of the capability's row, and `needs` the further rows of its
    driver, by table.
    """

    place: Place
    address: str
    path: str
    name: str = ""
    serial: str = ""
    type: str = ""
    what: str = ""
    row: str = ""
    held: bool = False
    text: str = ""
    settings: JsonObject = {}
    needs: list[tuple[str, JsonObject]] = []
    took_s: float = 0.0


def known_kinds(home: Path) -> tuple[dict[str, Kind], Known, list[str]]:
    """Return all installed kinds, the handshakes by type of device, and the faults of unusable kinds."""
    kinds, asked, wrong = {}, {}, []
    for name in registry.names(home):
        try:
            kind = registry.find(name, home)
            kinds[name] = kind
            if handshake := recognition.handshakes(kind):
                asked[kind.device_type] = handshake
        except KindError as err:
            wrong.append(str(err))
    return kinds, asked, wrong


def ask_all(
    ends: Collection[End], known: Known, held: Mapping[str, str], *, wait_s: float, ask: bool = True
) -> list[Attached]:
    """Return the device at each end; `held` maps nodes and i2c addresses in use to the robot's row."""

    def attached(end: End) -> list[Attached]:
        began = time.monotonic()
        found = _asked(end, known, held, wait_s=wait_s, ask=ask)
        took_s = round(time.monotonic() - began, 3)
        return [msgspec.structs.replace(each, took_s=took_s) for each in found]

    if not ends:
        return []
    with ThreadPoolExecutor(max_workers=min(AT_ONCE, len(ends))) as pool:
        return [each for several in pool.map(attached, ends) for each in several]


def held_by(robot: str, devices: Collection[DeviceRow]) -> dict[str, str]:
    """Return the nodes and i2c addresses of a running robot's rows, with a text for each."""
    return {node_of(row): f"robot '{robot}' runs with it as its device '{row.name}'" for row in devices}


def node_of(row: DeviceRow) -> str:
    """Return the node of a device row, or its address if it has no node now."""
    address = row.address
    if address.startswith("i2c:"):
        bus, _, at = address.removeprefix("i2c:").partition(":")
        try:
            return f"i2c:{int(bus)}:{int(at, 0):#04x}"
        except ValueError:
            return address
    if address.startswith(ANYWHERE):
        return path_of(address) or address
    if address.startswith(("/", "usb:", "by-id:")):
        try:
            return os.path.realpath(resolve(Device(row.name, row.type, address, {})))
        except DeviceError:
            return address
    return address


def _asked(end: End, known: Known, held: Mapping[str, str], *, wait_s: float, ask: bool) -> list[Attached]:
    plain = Attached(**{name: getattr(end, name) for name in End.__struct_fields__})
    if end.place == "input":
        return [msgspec.structs.replace(plain, text=INPUT_TEXT)]
    if end.place in {"video", "lirc", "gamepad"}:
        return [_by_name(plain, known, held)]
    try:
        return _bus(plain, known, held, ask=ask) if end.place == "i2c" else [_line(plain, known, held, wait_s, ask=ask)]
    except DeviceError as err:
        said = str(err).replace(f"device '{recognising.NAME}' at ", "")
        return [msgspec.structs.replace(plain, text=said + _group(end.path))]


def _by_name(end: Attached, known: Known, held: Mapping[str, str]) -> Attached:
    told = _recognised(end, recognising.by_name(end.place, end.name, known), "no driver here takes it")
    if by := held.get(os.path.realpath(end.path)):
        return msgspec.structs.replace(told, held=True, text=by)
    return msgspec.structs.replace(told, text=told.text or _rights(end.path))


def _line(end: Attached, known: Known, held: Mapping[str, str], wait_s: float, *, ask: bool) -> Attached:
    if by := held.get(os.path.realpath(end.path)):
        return msgspec.structs.replace(end, held=True, text=f"{by}: not opened")
    if by := holder(end.path):
        return msgspec.structs.replace(end, held=True, text=f"in use{by}: not opened")
    return _recognised(end, *recognising.serial(end.path, known, wait_s=wait_s, ask=ask))


def _bus(end: Attached, known: Known, held: Mapping[str, str], *, ask: bool) -> list[Attached]:
    skip = {int(one.rpartition(":")[2], 0): text for one, text in held.items() if one.startswith(f"{end.address}:0x")}
    used = [
        msgspec.structs.replace(end, address=f"{end.address}:{at:#04x}", held=True, text=f"{text}: not asked")
        for at, text in skip.items()
    ]
    if not ask:
        return [*used, msgspec.structs.replace(end, text="not asked: an i2c device sends nothing by itself")]
    found = recognising.at_i2c(end.address, known, skip)
    here = [
        _recognised(msgspec.structs.replace(end, address=f"{end.address}:{at:#04x}"), told, "") for at, told in found
    ]
    return [*used, *here] or [msgspec.structs.replace(end, text="nothing that a driver here knows answers on it")]


def _recognised(end: Attached, recognised: Found | None, text: str) -> Attached:
    if recognised is None:
        return msgspec.structs.replace(end, text=text)
    type_, seen = recognised
    return msgspec.structs.replace(
        end,
        type=type_,
        what=seen.what,
        serial=seen.serial or end.serial,
        settings=dict(seen.settings),
        needs=[(table, dict(row)) for table, row in seen.needs],
    )


def _rights(path: str) -> str:
    if not Path(path).exists() or os.access(path, os.R_OK | os.W_OK):
        return ""
    return f"it may not be opened by this user{_group(path)}"


def _group(path: str) -> str:
    """Return the command that gives this user the rights; the group is the file's own."""
    if not Path(path).exists() or os.access(path, os.R_OK | os.W_OK):
        return ""
    return f" ({join_group(Path(path))})"
