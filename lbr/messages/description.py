"""The description of a robot: its capabilities with their messages' schemas, its words, and the rows for people."""

from msgspec import Struct

from lbr.messages.kinematics import BaseKind
from lbr.messages.schema import JsonObject
from lbr.messages.system import Role

Schema = JsonObject
"""A JSON Schema; empty for a program without message types."""


class CommandDescription(Struct, frozen=True, kw_only=True):
    """A command: its message, its least role, and whether it is held by a lease."""

    schema: Schema
    role: Role
    leased: bool


class CapabilityDescription(Struct, frozen=True, kw_only=True):
    """A running capability: its kind, the streams under its own name, and its commands."""

    name: str
    kind: str
    family: str
    summary: str
    outputs: dict[str, Schema]
    commands: dict[str, CommandDescription]


class BaseDescription(Struct, frozen=True, kw_only=True):
    """The twists of a base: the capability that accepts them, sideways motion, the greatest speeds and power, and the
    longest motion without a changed command."""

    capability: str
    kind: BaseKind
    sideways: bool
    max_speed_mps: float
    max_turn_rps: float
    max_power: float = 1.0
    max_run_s: float = 30.0


class RobotDescription(Struct, frozen=True, kw_only=True):
    """A robot at a revision of its rows; its status has the values that change meanwhile.

    `words` are the console's, as in `help`; `wheels`, `ranges` and `phrases` are the rows of those tables. `base` is
    computed from `kinematics`, `wheel` and the drive's settings; null without a drive.
    """

    robot: str
    simulated: bool
    revision: int
    capabilities: tuple[CapabilityDescription, ...]
    words: tuple[JsonObject, ...] = ()
    wheels: tuple[JsonObject, ...] = ()
    ranges: tuple[JsonObject, ...] = ()
    phrases: tuple[JsonObject, ...] = ()
    base: BaseDescription | None = None
