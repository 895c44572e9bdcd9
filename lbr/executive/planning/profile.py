"""Launch profiles: which robot of the database runs, where its parts do, whether it is simulated, and on what devices."""

import os
from pathlib import Path

import msgspec
from msgspec import Struct

from lbr.database import resources
from lbr.errors import InputError


class Profile(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A launch profile. `only` and `without` name capabilities; `devices` replaces addresses; `listen` opens the bus.

    `hosts` says which capabilities another machine runs, by that host's name; `plugged_in_elsewhere` which of them own
    a device there.
    """

    robot: str
    description: str = ""
    simulate: bool = False
    only: tuple[str, ...] | None = None
    without: tuple[str, ...] = ()
    devices: dict[str, str] = {}
    listen: tuple[str, ...] = ()
    hosts: dict[str, tuple[str, ...]] = {}
    plugged_in_elsewhere: tuple[str, ...] = ()

    def host_of(self, name: str) -> str:
        """Return the other machine that runs a capability; empty: the robot's own does."""
        return next((host for host, names in self.hosts.items() if name in names), "")


def shipped() -> dict[str, Path]:
    """Return the profiles that come with lbr, by name."""
    return {path.stem: path for path in sorted(resources.launch_profiles().glob("*.toml"))}


def load(name: str) -> Profile:
    """Return a shipped profile by name, or one of your own by path; raise InputError saying what there is."""
    path = Path(name) if name.endswith(".toml") or os.sep in name else shipped().get(name)
    if path is None:
        raise InputError(
            f"there is no launch profile '{name}': {', '.join(shipped())}, or the path of a .toml file", "unknown_name"
        )
    try:
        return msgspec.toml.decode(path.read_bytes(), type=Profile)
    except OSError as err:
        raise InputError(f"launch profile {path}: {err.strerror}") from err
    except msgspec.DecodeError as err:
        raise InputError(f"launch profile {path}: {err}") from err
