"""The description of a robot: its capabilities with the schemas of their messages, its words, and rows that people look
at."""

from typing import Any

from msgspec import Struct

from lbr.messages.kinematics import BaseKind
from lbr.messages.system import Role

Schema = dict[str, Any]
"""A JSON Schema; empty where a program says nothing of its messages."""


class CommandDescription(Struct, frozen=True, kw_only=True):
    """A command: its message, the least role that may ask for it, and whether it is held by a lease."""

    schema: Schema
    role: Role
    leased: bool


class CapabilityDescription(Struct, frozen=True, kw_only=True):
    """A capability that runs: what it is, the streams that it publishes under its own name, and what it can be
    asked."""

    name: str
    kind: str
    family: str
    summary: str
    outputs: dict[str, Schema]
    commands: dict[str, CommandDescription]


class BaseDescription(Struct, frozen=True, kw_only=True):
    """The twists of a base: which capability takes them, whether it goes sideways too, its greatest speeds and power."""

    capability: str
    kind: BaseKind
    sideways: bool
    max_speed_mps: float
    max_turn_rps: float
    max_power: float = 1.0


class RobotDescription(Struct, frozen=True, kw_only=True):
    """A robot as of the revision of its rows: what changes meanwhile is in its status.

    `words` are the console's, as `help` has them; `wheels`, `ranges` and `phrases` the rows of those tables; `base`
    follows from `kinematics`, `wheel` and the settings of what drives, null without that.
    """

    robot: str
    simulated: bool
    revision: int
    capabilities: tuple[CapabilityDescription, ...]
    words: tuple[dict[str, Any], ...] = ()
    wheels: tuple[dict[str, Any], ...] = ()
    ranges: tuple[dict[str, Any], ...] = ()
    phrases: tuple[dict[str, Any], ...] = ()
    base: BaseDescription | None = None
