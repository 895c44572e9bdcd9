"""The part of the robot that docking sees and uses."""

from collections.abc import Generator
from dataclasses import dataclass
from typing import Literal, TypeVar

T = TypeVar("T")
Beam = Literal["left", "right", "power"]


@dataclass(frozen=True, slots=True)
class Ending:
    """How the last turn or move ended, or that a motion was refused: `final` if a user wants the robot to stand."""

    good: bool
    text: str
    final: bool = False


@dataclass(frozen=True, slots=True)
class View:
    """The robot now. Directions are degrees clockwise from how it looks when it is docked, its back to the dock.

    Null and the empty set are not known or not seen. `beams` are those seen in this moment. `ending` is of the action
    that was asked for last; null while it goes on.
    """

    time_s: float
    direction_deg: float
    forward_m: float | None = None
    back_m: float | None = None
    beams: frozenset[Beam] = frozenset()
    charging: bool | None = None
    rest_voltage_v: float | None = None
    ending: Ending | None = None


@dataclass(frozen=True, slots=True)
class Stand:
    """Stand still."""


@dataclass(frozen=True, slots=True)
class Say:
    """Stand still, and say a phrase; `text` is the same in the program's own words."""

    phrase: str
    text: str


@dataclass(frozen=True, slots=True)
class Back:
    """Drive back; `steer_deg` clockwise turns the robot clockwise meanwhile."""

    power: float
    steer_deg: float


@dataclass(frozen=True, slots=True)
class Turn:
    """Turn on the spot by an angle, clockwise positive."""

    angle_deg: float


@dataclass(frozen=True, slots=True)
class Go:
    """Drive straight for a distance, backwards if it is negative."""

    power: float
    distance_m: float


Action = Stand | Say | Back | Turn | Go
STAND = Stand()
Script = Generator[Action, View, T]
"""What is to be done goes out by `yield`, what is then seen comes in by it."""


class GivenUpError(Exception):
    """It cannot dock; the text says why."""
