"""Which types of devices can be emulated: those of lbr itself, and those that installed packages bring by entry point.

A package declares one in a module of its own, and names it in the group `lbr.twins`:

    TWIN = DeviceTwin(device="feetech", row=FeetechRow, entry=FeetechTwin)       # feetech = "my_arm.twin:TWIN"

Here nothing is imported before a device row of that type asks for it.
"""

import importlib
import pkgutil
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec

from msgspec import Struct

from lbr.capability.kind import KindError

GROUP = "lbr.twins"
OURS = "lbr.simulation.devices"
"""The folder of lbr's own: a module for each type of device, named as that."""


class TwinError(KindError):
    """A twin that cannot be used; the text names its package and says what to do."""


@dataclass(frozen=True, kw_only=True, slots=True)
class DeviceTwin:
    """How a type of device is emulated: what its device rows may set, and the class that does it.

    `device` is the type that device rows name. `row` has a field `faults`: what can be made to go wrong. `entry` is a class, or `module:Class`, which is imported
    only where the world runs; it is made with a device and its surroundings, see `lbr.simulation.twins.base.Twin`.
    """

    device: str
    row: type[Struct]
    entry: str | type

    def load(self) -> type:
        """Import and return the class that emulates it."""
        if isinstance(self.entry, type):
            return self.entry
        module, _, name = self.entry.partition(":")
        try:
            found = getattr(importlib.import_module(module), name)
        except Exception as err:
            raise TwinError(f"the twin of '{self.device}' ({self.entry}) does not load: {_said(err)}") from err
        if not isinstance(found, type):
            raise TwinError(f"the twin of '{self.device}' ({self.entry}) is no class; name one as module:Class")
        return found


def names() -> tuple[str, ...]:
    """Return every type of device that can be emulated, sorted; one that several packages claim is among them."""
    return tuple(sorted({*_ours(), *_brought()}))


def find(device_type: str) -> DeviceTwin | None:
    """Return how a type of device is emulated, or None; raise TwinError if what brings it is broken, or not alone."""
    if device_type in _ours():
        return _declared(device_type, f"{OURS}.{device_type}", "TWIN", "lbr")
    points = _brought().get(device_type, ())
    if len(points) > 1:
        said = " and ".join(sorted(map(_package, points)))
        raise TwinError(f"twins of '{device_type}' come with {said}: uninstall one")
    return _declared(device_type, points[0].module, points[0].attr, _package(points[0])) if points else None


def refused() -> tuple[str, ...]:
    """Return a sentence for each package whose twin is not used because its name is taken."""
    return tuple(
        f"the twin of '{name}' from {_package(point)} is not used: lbr has its own; give the device type another name"
        for name, points in sorted(_brought().items())
        if name in _ours()
        for point in points
    )


@lru_cache(maxsize=1)
def _ours() -> frozenset[str]:
    spec = find_spec(OURS)
    places = spec.submodule_search_locations if spec is not None else None
    return frozenset(module.name for module in pkgutil.iter_modules(places or []))


@lru_cache(maxsize=1)
def _brought() -> Mapping[str, tuple[EntryPoint, ...]]:
    found: dict[str, dict[str, EntryPoint]] = {}
    for point in entry_points(group=GROUP):
        found.setdefault(point.name, {})[point.value] = point
    return {name: tuple(points.values()) for name, points in found.items()}


@cache
def _declared(device_type: str, module: str, name: str, package: str) -> DeviceTwin:
    where = f"the twin of '{device_type}' from {package} ({module}:{name})"
    try:
        twin = getattr(importlib.import_module(module), name)
    except Exception as err:
        raise TwinError(f"{where} does not load: {_said(err)}; mend or uninstall that package") from err
    if not isinstance(twin, DeviceTwin):
        raise TwinError(f"{where} is no DeviceTwin(…)")
    if twin.device != device_type:
        raise TwinError(f"{where} is of device '{twin.device}': entry point and DeviceTwin.device must agree")
    if "faults" not in getattr(twin.row, "__struct_fields__", ()):
        raise TwinError(f"{where}: its row must be a msgspec Struct with a field `faults`")
    return twin


def _package(point: EntryPoint) -> str:
    return f"package '{point.dist.name}'" if point.dist is not None else f"'{point.value}'"


def _said(err: Exception) -> str:
    return f"{type(err).__name__}: {' '.join(str(err).split())[:200]}"
