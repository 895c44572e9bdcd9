"""The part of the robot that a manoeuvre sees and uses."""

from collections.abc import Generator
from dataclasses import dataclass
from typing import Literal, TypeVar

from lbr.messages.codes import Code

T = TypeVar("T")
Beam = Literal["left", "right", "power"]


@dataclass(frozen=True, slots=True)
class Ending:
    """The end of a motion or a manoeuvre, by the list of codes: `final` if the robot is to stand, or is another's."""

    good: bool
    text: str
    code: Code = "done"
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
    ending: Ending | None = None


@dataclass(frozen=True, slots=True)
class Stand:
    """Stand still."""


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


Action = Stand | Back | Turn | Go
STAND = Stand()
Script = Generator[Action, View, T]
"""Orders go out by `yield`, views come in by it."""


class GivenUpError(Exception):
    """It cannot be done: why, by the list of codes, and in words."""

    def __init__(self, text: str, code: Code) -> None:
        super().__init__(text)
        self.code = code
