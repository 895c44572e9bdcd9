"""Launch profiles: which robot runs, where its parts run, whether it is simulated, and on which devices."""

import os
from collections.abc import Iterator
from pathlib import Path

import msgspec
from msgspec import Struct

from lbr import plugins
from lbr.database import given_files
from lbr.errors import InputError
from lbr.messages.unreadable import UNREADABLE
from lbr.names import did_you_mean
from lbr.robot import registry
from lbr.robot.registry import Found

LARGEST_BYTES = 1_000_000


class Profile(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A launch profile. `only` and `without` name capabilities; `devices` replaces addresses; `listen` opens the bus.

    `processes` names the process of a capability, in place of its row's.

    `calibration` holds the values of devices that have no row of that table, such as those that a simulated world made.

    `hosts` lists the capabilities on other machines, by the host's name; `plugged_in_elsewhere` those of them that own
    a device there.

    `demo` lists the commands of `lbr` that `lbr demo` runs.
    """

    robot: str
    description: str = ""
    simulate: bool = False
    only: tuple[str, ...] | None = None
    without: tuple[str, ...] = ()
    processes: dict[str, str] = {}
    devices: dict[str, str] = {}
    calibration: dict[str, dict[str, float]] = {}
    listen: tuple[str, ...] = ()
    hosts: dict[str, tuple[str, ...]] = {}
    plugged_in_elsewhere: tuple[str, ...] = ()
    demo: tuple[str, ...] = ()

    def host_of(self, name: str) -> str:
        """Return the other machine that runs a capability; empty for the robot's own."""
        return next((host for host, names in self.hosts.items() if name in names), "")


_KEYED: dict[str, object] = {
    "processes": str,
    "devices": str,
    "calibration": dict[str, float],
    "hosts": tuple[str, ...],
}
"""Fields whose keys are names, with the type of their values."""


def names() -> list[str]:
    """Return the names of the profiles that come with robots, by robot."""
    return [name for found in registry.every() for name in of_robot(found)]


def of_robot(installed: Found) -> list[str]:
    """Return the names of a robot's profiles; a robot without one of its own name also runs as its rows say."""
    if installed.robot is None:
        return []
    brought = list(registry.profiles(installed.robot))
    plain = any(registry.plain(name) == installed.name for name in brought)
    return brought if plain else [installed.name.replace("_", "-"), *brought]


def load(name: str) -> Profile:
    """Return a robot's profile by name, or one of your own by path; raise InputError listing the profiles there are."""
    if name.endswith(".toml") or os.sep in name:
        return _read(Path(name))
    for installed in registry.of_profile(name):
        if installed.robot is None:
            raise InputError(installed.fault)
        for brought, path in registry.profiles(installed.robot).items():
            if registry.plain(brought) == registry.plain(name):
                return _own(installed, path)
        if registry.plain(name) == installed.name:
            return Profile(robot=installed.name, description=installed.robot.summary)
    raise InputError(
        f"there is no launch profile '{name}'; {did_you_mean(name, names())}; "
        'for a robot of your own rows write a .toml file with robot = "NAME", and give its path'
        f"{plugins.perhaps_broken()}",
        "unknown_name",
    )


def faults(installed: Found) -> Iterator[str]:
    """Yield the reasons for which a robot's profiles are refused."""
    for path in registry.profiles(installed.robot).values() if installed.robot is not None else ():
        try:
            _own(installed, path)
        except InputError as err:
            yield str(err)


def _own(installed: Found, path: Path) -> Profile:
    """Return a profile of a package, which starts that package's robot and no other."""
    profile = _read(path)
    if profile.robot != installed.name:
        raise InputError(
            f"launch profile {path} of package '{installed.package}': its robot must be '{installed.name}'"
        )
    return profile


def _read(path: Path) -> Profile:
    try:
        content = given_files.read(path, LARGEST_BYTES)
    except InputError as err:
        raise InputError(f"launch profile {err}") from err
    try:
        text = given_files.unicode_text(content)
        return msgspec.toml.decode(text, type=Profile)
    except UnicodeDecodeError as err:
        raise InputError(f"launch profile {path} is no text: save it as UTF-8") from err
    except UNREADABLE as err:
        raise InputError(f"launch profile {path}: {_with_key(str(err), text)}") from err


def _with_key(complaint: str, text: str) -> str:
    """Return msgspec's complaint about a profile, with the key in place of `[...]`."""
    for field, kind in _KEYED.items():
        if f"$.{field}[...]" in complaint:
            for key, value in msgspec.toml.decode(text)[field].items():
                try:
                    msgspec.convert(value, kind)
                except msgspec.ValidationError:
                    return complaint.replace("[...]", f".{key}", 1)
    return complaint
