"""Messages on `beacon/*`: manoeuvres by the beams of a charging dock, and their progress."""

from typing import Literal

from msgspec import Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.leases import LeaseId
from lbr.messages.units import TtlS

Manoeuvre = Literal["align", "search", "follow", "withdraw", "roam"]
MANOEUVRES: tuple[Manoeuvre, ...] = ("align", "search", "follow", "withdraw", "roam")


class SeekCommand(Struct, frozen=True, kw_only=True):
    """Do a manoeuvre, while the lease is renewed with the same command.

    `align`: turn the back to the dock's wall, as far off as the beams are wide. `search`: go along it to a beam.
    `follow`: back up between the beams until a touch. `withdraw`: drive away from the dock, towards the middle of its
    beams. `roam`: go where there is most room.
    """

    manoeuvre: Manoeuvre
    lease: LeaseId = ""
    ttl_s: TtlS | None = None
    take_over: bool = False


class BeaconState(Struct, frozen=True, kw_only=True):
    """The manoeuvre under way, its holder and goal; `reason` and `code` of the last end.

    `dock_side`: where the middle of the beams last was; empty: between them, or unknown.
    `risen_v`: the rise of the battery's voltage without load since then.
    """

    manoeuvre: Literal["", "align", "search", "follow", "withdraw", "roam"] = ""
    holder: str | None = None
    goal: str | None = None
    dock_side: Literal["", "left", "right"] = ""
    risen_v: float | None = None
    reason: str = ""
    code: ReasonCode = ""
