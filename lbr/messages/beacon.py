"""Messages on `beacon/*`: manoeuvres by the beams of a charging dock, and how they go."""

from typing import Literal

from msgspec import Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.leases import LeaseId
from lbr.messages.units import TtlS

Manoeuvre = Literal["align", "search", "follow", "withdraw", "roam"]
MANOEUVRES: tuple[Manoeuvre, ...] = ("align", "search", "follow", "withdraw", "roam")


class SeekCommand(Struct, frozen=True, kw_only=True):
    """Go through a manoeuvre, for as long as the lease is renewed with the same command.

    `align` turns the back to the wall of the dock, as far from it as the beams are wide; `search` goes along it until a
    beam is seen; `follow` backs up between the beams until something is touched; `withdraw` drives away from a dock
    that is near, towards the middle of its beams; `roam` looks all around and goes where there is most room.
    """

    manoeuvre: Manoeuvre
    lease: LeaseId = ""
    ttl_s: TtlS | None = None
    take_over: bool = False


class BeaconState(Struct, frozen=True, kw_only=True):
    """The manoeuvre under way, empty for none, with its holder and goal; `reason` and `code` are how the last one
    ended.

    `dock_side` is to which side of the robot, as it looks, the middle of the beams was when it last followed them;
    empty: it was between them, or did not follow them yet. `risen_v` is how far the battery's voltage without load rose
    since then.
    """

    manoeuvre: Literal["", "align", "search", "follow", "withdraw", "roam"] = ""
    holder: str | None = None
    goal: str | None = None
    dock_side: Literal["", "left", "right"] = ""
    risen_v: float | None = None
    reason: str = ""
    code: ReasonCode = ""
