"""The devices of the rows: their owners, their permitted settings, and their addresses in this run. Pure."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from msgspec import Struct

from lbr.capability import twins
from lbr.capability.kind import Kind
from lbr.capability.settings import faults
from lbr.capability.twins import TwinError
from lbr.database.reading import Problem
from lbr.database.rows import CapabilityRow, DeviceRow, RobotRows
from lbr.executive.planning.profile import Profile
from lbr.executive.planning.run_identity import RunIdentity


def check_device_settings(rows: RobotRows, kinds: Mapping[str, Kind], *, simulated: bool) -> list[Problem]:
    """Return the faults in the settings of device rows, for kinds that read them and, in a simulation, for twins."""
    devices = [(device, f"{rows.robot.name}/{device.name}") for device in rows.devices]
    devices += [
        (faulty.row, faulty.label)
        for faulty in rows.faulty
        if faulty.table == "device" and not faulty.columns & {"type", "settings"}
    ]
    problems = []
    for device, label in devices:
        for kind in {id(kind): kind for kind in kinds.values() if kind.rights.emulates}.values():
            of_type, wrong = _settable(device.type)
            if of_type is not None:
                said = [f"{fault} (for kind '{kind.name}')" for fault in faults(of_type, device.settings)]
                problems += [Problem("device", label, "settings", one) for one in said]
            elif wrong and simulated:
                problems.append(Problem("device", label, "type", wrong))
    return problems


def _settable(device_type: str) -> tuple[type[Struct] | None, str]:
    """Return the settings of a device row that an emulating world accepts, or why they are unknown."""
    try:
        twin = twins.find(device_type)
    except TwinError as err:
        return None, str(err)
    return (twin.row, "") if twin is not None else (None, "")


def check_devices(
    rows: RobotRows, chosen: list[CapabilityRow], kinds: Mapping[str, Kind], settings: Mapping[str, Struct]
) -> list[Problem]:
    """Return which capabilities name a device of another type, or a device that another capability owns."""
    problems = []
    devices = {device.name: device for device in rows.devices}
    owners: dict[str, str] = {}
    for row in chosen:
        wanted = kinds[row.name].device_type
        if not wanted or row.name not in settings:
            continue
        name = str(getattr(settings[row.name], "device", ""))
        device = devices.get(name)
        if device is None:
            continue
        if device.type != wanted:
            text = f"device '{name}' is of type '{device.type}', and this kind drives '{wanted}'"
        elif name in owners:
            text = f"device '{name}' already belongs to '{owners[name]}'; one capability owns a device"
        else:
            owners[name] = row.name
            continue
        problems.append(Problem("capability", f"{rows.robot.name}/{row.name}", "settings", f"device: {text}"))
    return problems


def device_address(device: DeviceRow, kinds: Iterable[Kind], profile: Profile, site: RunIdentity, robot: str) -> str:
    """Return the address of a device in this run: that of its emulated twin, the profile's, or the row's."""
    driver = next((kind for kind in kinds if kind.device_type == device.type), None)
    emulated = driver.device.emulated if driver is not None and driver.device is not None else "tty"
    if not profile.simulate or not (emulated == "folder" or device.type in twins.names()):
        return profile.devices.get(device.name, device.address)
    place = str(Path(site.home) / "run" / f"{robot}-devices" / device.name)
    return f"unix:{place}" if emulated == "socket" else place
