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
    """For how many readings something has been so, and since when."""

    since_s: float
    samples: int


@dataclass(frozen=True, slots=True)
class Watch:
    """The phase. `until_s` is when it ends, `seen_s` when the supply was read last."""

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
class Told:
    """News for people; `about` is whose command it was that did it."""

    kind: str
    text: str
    level: str = "warning"
    about: str = ""


@dataclass(frozen=True, slots=True)
class Reading:
    """The supply said something."""

    ups: UpsState


@dataclass(frozen=True, slots=True)
class Arm:
    """A sender arms or disarms; None: as it was."""

    armed: bool
    warn_v: float | None = None
    shutdown_v: float | None = None
    sender: str = ""


@dataclass(frozen=True, slots=True)
class Cancel:
    """A sender cancels a shutdown."""

    sender: str


@dataclass(frozen=True, slots=True)
class Parked:
    """The robot is down and released, or will never be."""

    trouble: str = ""


@dataclass(frozen=True, slots=True)
class Answered:
    """The answer of logind to the request to power off; `pretended`: it was not asked, because nothing here is real."""

    trouble: str = ""
    pretended: bool = False


@dataclass(frozen=True, slots=True)
class Tick:
    """Time goes on."""


Event = Reading | Arm | Cancel | Parked | Answered | Tick
Outcome = tuple[Watch, tuple[Task | Told, ...]]
