"""The twins that emulate devices: the `twins` of lbr's and other packages' components. A package declares a twin in a
module of its own, and names it in its component:

    TWIN = DeviceTwin(device="feetech", row=FeetechRow, entry=FeetechTwin)       # in my_arm/twin.py
    COMPONENT = Component(twins={"feetech": "my_arm.twin:TWIN"})

The module is imported only for a device row of that type.
"""

from dataclasses import dataclass
from typing import Any

from msgspec import Struct

from lbr import plugins
from lbr.capability.kind import KindError
from lbr.errors import told
from lbr.plugins import Plugin, PluginError


class TwinError(KindError):
    """A twin that cannot be used; the text has its package and the cure."""


@dataclass(frozen=True, kw_only=True, slots=True)
class DeviceTwin:
    """The emulation of a type of device: the settings of its device rows, and its class.

    `device` is the type that device rows name. `row` has a field `faults`: the faults that it can simulate. `entry` is
    a class, or `module:Class`, which is imported only where the world runs. It is made with a device and its
    surroundings, see `lbr.simulation.twins.base.Twin`. `player` (`module:Class`) plays motions that the device stores,
    for trials without its line: see `lbr.simulation.trials.body.Player`.
    """

    device: str
    row: type[Struct]
    entry: str | type
    player: str = ""

    def load_player(self) -> Any:
        """Import and return the player of motions that the device stores, or None."""
        return plugins.load(self.player)() if self.player else None

    def load(self) -> type:
        """Import and return the class that emulates the device."""
        if isinstance(self.entry, type):
            return self.entry
        try:
            twin = plugins.load(self.entry)
        except (Exception, SystemExit) as err:
            raise TwinError(f"the twin of '{self.device}' ({self.entry}) does not load: {told(err)}") from err
        if not isinstance(twin, type):
            raise TwinError(f"the twin of '{self.device}' ({self.entry}) is not a class; name one as module:Class")
        return twin


def names() -> tuple[str, ...]:
    """Return every type of device that can be emulated, sorted, including types that several packages claim."""
    return tuple(sorted(plugins.installed("twins")))


def find(device_type: str) -> DeviceTwin | None:
    """Return the twin of a type of device, or None; raise TwinError if its package is broken, or not the only one."""
    point = plugins.find("twins", device_type)
    return _declared(point) if point is not None else None


def refused(device_type: str = "") -> tuple[str, ...]:
    """Return one sentence for each package whose twin is ignored because its name is taken; of that type, or of any."""
    found = (one for one in plugins.every("twins") if one.refusal and device_type in {"", one.name})
    return tuple(f"the twin {one.label}: {one.refusal}" for one in found)


@plugins.remembered
def _declared(point: Plugin) -> DeviceTwin:
    try:
        twin = point.checked(point.load(), DeviceTwin, "device")
    except PluginError as err:
        raise TwinError(f"the twin {err}") from err
    if "faults" not in getattr(twin.row, "__struct_fields__", ()):
        raise TwinError(f"the twin {PluginError(point, 'its row must be a msgspec Struct with a field `faults`')}")
    return twin
