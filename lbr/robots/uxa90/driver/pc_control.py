"""In which mode the main board is taken to be: a pure function of what it was told, what it said, and time.

unknown ─take─► taking ─answer, or settled─► pc ─a stored motion, or no answer ─► normal ─take─► taking …
"""

from dataclasses import dataclass, replace
from math import inf

from lbr.robots.uxa90.driver.messages import ControllerMode

HEARD_S = 0.05
"""From the main board's answer to the first packet that it is relied on to pass on."""


@dataclass(frozen=True, slots=True)
class PcControl:
    """`since` it is so; `ready_at` is when taking control is over. `answered`: it has said so itself."""

    name: ControllerMode = "unknown"
    since: float = -inf
    ready_at: float = inf
    answered: bool = False

    @property
    def pc(self) -> bool:
        """Return whether packets are passed on to servos."""
        return self.name == "pc"


def taking(now: float, settle_s: float) -> PcControl:
    """The frame that takes control was written."""
    return PcControl("taking", now, now + settle_s)


def heard(mode: PcControl, now: float) -> PcControl:
    """The main board answered that frame."""
    if mode.name != "taking":
        return mode
    return replace(mode, ready_at=min(mode.ready_at, now + HEARD_S), answered=True)


def left(now: float) -> PcControl:
    """It was told to play as by its remote control, or is found to pass nothing on."""
    return PcControl("normal", now)


def tick(mode: PcControl, now: float) -> PcControl:
    """Let time pass."""
    if mode.name == "taking" and now >= mode.ready_at:
        return PcControl("pc", now, answered=mode.answered)
    return mode
