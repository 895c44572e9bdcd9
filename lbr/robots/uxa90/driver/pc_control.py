"""The assumed mode of the main board: a pure function of its orders, its answers, and time.

unknown ─take─► taking ─answer, or settled─► pc ─a stored motion, or no answer ─► normal ─take─► taking …
"""

from dataclasses import dataclass, replace
from math import inf

from lbr.robots.uxa90.driver.messages import ControllerMode

ANSWERED_S = 0.05
"""The time from the main board's answer to the first packet that it can be relied on to pass on."""


@dataclass(frozen=True, slots=True)
class PcControl:
    """The mode, and `since` when; `ready_at` is the end of taking control. `answered`: the board has confirmed it."""

    name: ControllerMode = "unknown"
    since: float = -inf
    ready_at: float = inf
    answered: bool = False

    @property
    def pc(self) -> bool:
        """Return whether packets are passed on to servos."""
        return self.name == "pc"


def taking(now: float, settle_s: float) -> PcControl:
    """Return the mode after the frame that takes control was written."""
    return PcControl("taking", now, now + settle_s)


def answered_frame(mode: PcControl, now: float) -> PcControl:
    """Return the mode after the main board answered that frame."""
    if mode.name != "taking":
        return mode
    return replace(mode, ready_at=min(mode.ready_at, now + ANSWERED_S), answered=True)


def normal(now: float) -> PcControl:
    """Return the mode after an order of the remote control, or when the board is seen to pass nothing on."""
    return PcControl("normal", now)


def tick(mode: PcControl, now: float) -> PcControl:
    """Return the mode at a later time."""
    if mode.name == "taking" and now >= mode.ready_at:
        return PcControl("pc", now, answered=mode.answered)
    return mode
