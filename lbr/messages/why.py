"""Why a part of the robot stands still: the links from the command to the motor, and the first that holds it."""

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
"""The kind of a link. `line`, `fault` and `motor` are the robot's hardware, all others are not."""
HARDWARE: frozenset[LinkName] = frozenset({"line", "fault", "motor"})
LinkState = Literal["ok", "past", "doubt", "held", "unknown"]
"""`held`: it keeps the part still. `doubt`: it prevents some motions. `past`: it ended the last motion. `unknown`:
there is no information."""


class Link(Struct, frozen=True):
    """A link of the chain: its subject, its state and the reason, in one sentence with its code.

    `since_s` is the age of the state, null: not known. `age_s` is the age of the newest information. `evidence` is its
    source, and `do` the cure: what to type or to look at.
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
    """A part to mend: the reason, and the cure.

    `waits` names the parts that are held by it. `device`: its device is missing, not its process.
    """

    part: str
    text: str
    do: str = ""
    device: bool = False
    waits: tuple[str, ...] = ()


class Chain(Struct, frozen=True, kw_only=True):
    """Why a part stands still, in one sentence: that of the first link that holds it. `first` is its place in `links`.

    Of the whole robot, `repairs` are the parts to mend, the one that holds the most first.

    `state` is that link's. `ok`: nothing holds it. `source` is the robot's bus, or only its rows if the robot does not
    answer.
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
