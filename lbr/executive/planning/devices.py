"""The devices of the rows: their owners, their permitted settings, and their addresses in this run. Pure."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from msgspec import Struct

from lbr.capability import twins
from lbr.capability.kind import Kind
from lbr.capability.settings import faults
from lbr.capability.twins import TwinError
from lbr.database.reading import Problem
from lbr.database.rows import DeviceRow
from lbr.executive.planning.draft import Draft
from lbr.executive.planning.profile import Profile
from lbr.executive.planning.run_identity import RunIdentity


def check_device_settings(draft: Draft) -> Iterator[Problem]:
    """Yield the faults in the settings of device rows, for kinds that read them and, in a simulation, for twins."""
    devices = [(row, label) for row, label, bad in draft.rows.every(DeviceRow) if not bad & {"type", "settings"}]
    worlds = {id(kind): kind for kind in draft.kinds.values() if kind.rights.emulates}.values()
    for device, label in devices:
        for kind in worlds:
            of_type, wrong = _settable(device.type)
            if of_type is not None:
                for fault in faults(of_type, device.settings):
                    yield Problem("device", label, "settings", f"{fault} (for kind '{kind.name}')")
            elif wrong and draft.profile.simulate:
                yield Problem("device", label, "type", wrong)


def _settable(device_type: str) -> tuple[type[Struct] | None, str]:
    """Return the settings of a device row that an emulating world accepts, or why they are unknown."""
    try:
        twin = twins.find(device_type)
    except TwinError as err:
        return None, str(err)
    return (twin.row, "") if twin is not None else (None, "")


def check_devices(draft: Draft) -> Iterator[Problem]:
    """Yield which capabilities name a device of another type, or a device that another capability owns."""
    devices = {device.name: device for device in draft.rows.devices}
    owners: dict[str, str] = {}
    for row in draft.chosen:
        wanted = draft.kinds[row.name].device_type
        name = str(getattr(draft.settings.get(row.name), "device", ""))
        device = devices.get(name)
        if not wanted or device is None:
            continue
        if device.type != wanted:
            text = f"device: device '{name}' is of type '{device.type}', and this kind drives '{wanted}'"
            yield draft.problem(row.name, "settings", text)
        elif name in owners:
            text = f"device: device '{name}' already belongs to '{owners[name]}'; one capability owns a device"
            yield draft.problem(row.name, "settings", text)
        else:
            owners[name] = row.name


def device_address(device: DeviceRow, kinds: Iterable[Kind], profile: Profile, site: RunIdentity, robot: str) -> str:
    """Return the address of a device in this run: that of its emulated twin, the profile's, or the row's."""
    driver = next((kind for kind in kinds if kind.device_type == device.type), None)
    emulated = driver.device.emulated if driver is not None and driver.device is not None else "tty"
    if not profile.simulate or not (emulated == "folder" or device.type in twins.names()):
        return profile.devices.get(device.name, device.address)
    place = str(Path(site.home) / "run" / f"{robot}-devices" / device.name)
    return f"unix:{place}" if emulated == "socket" else place
