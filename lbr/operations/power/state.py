"""State, events and outputs of the file-safe shutdown. Data only."""

from dataclasses import dataclass
from math import inf
from typing import Literal

from lbr.messages.power import PowerPhase, UpsState
from lbr.operations.power.supply import View

Task = Literal["park", "stop_parking", "power_off", "ask_can", "keep"]
UNREAD = View(trouble="the supply was not read yet")


@dataclass(frozen=True, slots=True)
class Run:
    """The number of successive readings in a condition, and its beginning."""

    since_s: float
    samples: int


@dataclass(frozen=True, slots=True)
class Watch:
    """The phase. `until_s` is its end, `seen_s` the time of the last reading."""

    armed: bool
    warn_v: float
    shutdown_v: float
    phase: PowerPhase
    seen_s: float
    view: View = UNREAD
    reason: str = ""
    until_s: float = inf
    low: Run | None = None
    well: Run | None = None
    wanting: Run | None = None
    warned: bool = False
    silent: bool = False
    cancelled: bool = False


@dataclass(frozen=True, slots=True)
class News:
    """News for people; `about` is the sender of the command that caused it."""

    kind: str
    text: str
    level: str = "warning"
    about: str = ""


@dataclass(frozen=True, slots=True)
class Reading:
    """A reading of the supply."""

    ups: UpsState


@dataclass(frozen=True, slots=True)
class Arm:
    """A sender's request to arm or disarm; None leaves a threshold unchanged."""

    armed: bool
    warn_v: float | None = None
    shutdown_v: float | None = None
    sender: str = ""


@dataclass(frozen=True, slots=True)
class Cancel:
    """A sender's request to cancel a shutdown."""

    sender: str


@dataclass(frozen=True, slots=True)
class Parked:
    """The end of parking: the robot is down and released, or failed to be."""

    trouble: str = ""


@dataclass(frozen=True, slots=True)
class Answered:
    """The answer of logind to the request to power off; `pretended`: it was not asked, as the supply is emulated."""

    trouble: str = ""
    pretended: bool = False


@dataclass(frozen=True, slots=True)
class Tick:
    """The time of a round."""


Event = Reading | Arm | Cancel | Parked | Answered | Tick
Outcome = tuple[Watch, tuple[Task | News, ...]]
