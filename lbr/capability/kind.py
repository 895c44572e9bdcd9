"""Kinds: what a capability row may name. Declared once per driver, operation or app; light to import."""

import contextlib
import importlib
import importlib.util
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import msgspec
from msgspec import Struct

from lbr.errors import LbrError
from lbr.messages.system import Role

STOP = "stop"
Family = Literal["driver", "operation", "app", "simulation", "program"]
Emulation = Literal["tty", "socket", "folder"]
Line = Literal["", "serial", "polled"]
Table = Literal["phrase", "choreography", "joint", "motion", "motor", "button", "user_token"]


class KindError(LbrError):
    """A kind that does not exist or cannot be loaded; the text says why and what there is instead."""


class NoSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """A row of this kind has nothing to set."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Kind:
    """One kind of driver, operation or app: its settings, its ports and where its code is.

    `entry` names the class that runs (`module:Class`), imported only in its own process, or is that class.
    `inputs` are streams it reads and `setpoints` streams sent to its own key, which only the wired source may write.
    `outputs` are streams it publishes, `commands` what it answers, `requests` what it asks of others' commands.
    `optional` are the inputs that it can do without: nobody is told that nothing feeds them.
    `roles` are the commands that need another role than `operate`; anybody may stop.
    `moves` marks a path to a motor: it gets the emergency stop on a session of its own and is stopped first.
    `serves` marks a way by which people move and stop the robot: it ranks with what moves.
    `device` is the type of the device row that the setting `device` must name; empty if it owns none.
    `device_settings` is what rows of a type of device may set for it; a world that `emulates` every device that has a
    twin (see `lbr.capability.twins`) gets theirs.
    `line` says that its device is on a serial line, whose address may be `usb:VID:PID` or `by-id:GLOB`; `polled`: it is
    asked many times a second, so that what an adapter holds back matters.
    `emulated` is what stands in for its device in a simulation: a tty, a socket (`unix:PATH`) or a folder.
    `calibrates` is the setting that names the device row whose calibration it gets, and may write back.
    `rows` are the tables whose rows it gets.
    `extra` is the extra of the package without which it cannot run at all, and `package` what that brings to import.
    """

    name: str
    summary: str
    family: Family
    entry: str | type
    settings: type[Struct] = NoSettings
    inputs: Mapping[str, type[Struct]] = field(default_factory=dict)
    setpoints: Mapping[str, type[Struct]] = field(default_factory=dict)
    outputs: Mapping[str, type[Struct]] = field(default_factory=dict)
    commands: Mapping[str, type[Struct]] = field(default_factory=dict)
    replies: Mapping[str, type[Struct]] = field(default_factory=dict)
    requests: Mapping[str, type[Struct]] = field(default_factory=dict)
    optional: Collection[str] = ()
    roles: Mapping[str, Role] = field(default_factory=dict)
    moves: bool = False
    serves: bool = False
    device: str = ""
    device_settings: Mapping[str, type[Struct]] = field(default_factory=dict)
    emulates: bool = False
    emulated: Emulation = "tty"
    line: Line = ""
    calibrates: str = ""
    rows: tuple[Table, ...] = ()
    extra: str = ""
    package: str = ""

    def role(self, command: str) -> Role:
        """Return the role that a command needs of whoever asks from another machine."""
        return self.roles.get(command, "view" if command == STOP else "operate")

    def lacks(self) -> str:
        """Return what has to be installed before it can run at all, and how; empty if nothing has."""
        with contextlib.suppress(ImportError, ValueError):
            if not self.package or importlib.util.find_spec(self.package) is not None:
                return ""
        return f"'{self.package}' is not installed: pip install 'lbr[{self.extra}]'"

    def parse(self, settings: str | bytes) -> Any:
        """Return the settings of a row, checked; raise msgspec.ValidationError naming the field."""
        return msgspec.json.decode(settings, type=self.settings)

    def load(self) -> type:
        """Import and return the class that runs."""
        if isinstance(self.entry, type):
            return self.entry
        module, _, name = self.entry.partition(":")
        found = getattr(importlib.import_module(module), name)
        if not isinstance(found, type):
            raise TypeError(f"kind '{self.name}': {self.entry} is no class")
        return found
