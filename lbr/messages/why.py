"""Why a part of the robot stands still: the links from what was asked to what moves, and the first that holds it."""

from typing import Literal

from msgspec import Struct

from lbr.messages.codes import ReasonCode

LinkName = Literal[
    "asker",
    "executive",
    "machine",
    "rows",
    "row",
    "process",
    "estop",
    "holder",
    "power",
    "wire",
    "input",
    "reading",
    "rule",
    "setpoint",
    "port",
    "line",
    "arming",
    "switch",
    "torque",
    "fault",
    "limit",
    "rate",
    "motor",
    "last",
    "refused",
]
"""Where in a chain a link is. `line`, `fault` and `motor` are the robot's hardware, all others are not."""
HARDWARE: frozenset[LinkName] = frozenset({"line", "fault", "motor"})
LinkState = Literal["ok", "past", "doubt", "held", "unknown"]
"""`held`: it keeps the part still. `doubt`: it does so for some of what may be asked. `past`: it did, and ended what
was under way. `unknown`: nothing says."""


class Link(Struct, frozen=True):
    """A link of the chain: of whom it tells, how that is and why, in one sentence with its code.

    `since_s` is for how long it has been so, null: not known. `age_s` is how old the newest word of it is. `evidence`
    is where that was read, and `do` what to type or to look at.
    """

    name: LinkName
    about: str
    state: LinkState
    text: str
    code: ReasonCode = ""
    since_s: float | None = None
    age_s: float | None = None
    evidence: str = ""
    do: str = ""


class Repair(Struct, frozen=True, kw_only=True):
    """A part to mend: the reason, and what to do. `waits` names the parts that are not well because of it.

    `device`: its device is away, and not its process.
    """

    part: str
    text: str
    do: str = ""
    device: bool = False
    waits: tuple[str, ...] = ()


class Chain(Struct, frozen=True, kw_only=True):
    """Why a part stands still, in one sentence: that of the first link that holds it. `first` is its place in `links`.

    Of the whole robot, `repairs` are the parts to mend, the one that holds the most first.

    `state` is that link's. `ok`: nothing holds it. `source` says what could be asked: the robot's bus, or its rows
    alone because nothing of it answers.
    """

    robot: str
    part: str
    state: LinkState
    text: str
    code: ReasonCode = ""
    since_s: float | None = None
    evidence: str = ""
    do: str = ""
    first: int | None = None
    source: Literal["bus", "rows"] = "bus"
    links: tuple[Link, ...] = ()
    repairs: tuple[Repair, ...] = ()
