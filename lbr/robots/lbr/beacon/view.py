"""The part of the robot that a manoeuvre sees and uses."""

from collections.abc import Generator
from dataclasses import dataclass
from typing import Literal, TypeVar

from lbr.messages.codes import Code

T = TypeVar("T")
Beam = Literal["left", "right", "power"]


@dataclass(frozen=True, slots=True)
class Ending:
    """The end of a motion or a manoeuvre, with its code; `final`: the robot must stand, or has another holder."""

    good: bool
    text: str
    code: Code = "done"
    final: bool = False


@dataclass(frozen=True, slots=True)
class View:
    """The robot now. Directions are degrees clockwise from the docked robot's, whose back is to the dock.

    None and the empty set mean unknown or not seen. `beams` are those in sight now. `ending` is of the last action;
    None while it continues.
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
"""A coroutine of a manoeuvre: it yields actions and receives views."""


class GivenUpError(Exception):
    """The manoeuvre cannot be done: the reason as a code, and in words."""

    def __init__(self, text: str, code: Code) -> None:
        super().__init__(text)
        self.code = code
