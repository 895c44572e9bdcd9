"""The wanted and the sent order for one servo."""

from dataclasses import dataclass
from math import inf

from lbr.drivers.servos.torque import Target
from lbr.messages.servos import ServoGoal

NEAR = 12
"""Counts: a servo so near its goal may go there at the torque that was asked for."""
STRIDE, FASTEST_CPS = 24, 400.0
"""Counts, and counts a second: so far it is from goal to goal of a servo that is led step by step."""
LIMP = "was released by the main board's motion; switch its torque off, then on"
BRAKED = "was braked by the emergency stop; switch its torque off, then on"


@dataclass(slots=True)
class TargetState(Target):
    """One servo. `count`: its goal, None where unknown.

    `want` is the packet that is to be said, `said` the one that was, `told_at` when. `carried`: it may have had torque
    before the line was opened; it is held where it is until a new motion begins. `overtaken`: a goal from before a
    stop, which is not gone to. `led`: where a motion of the main board is said to have led it.
    """

    count: int | None = None
    level: int = 0
    want: bytes | None = None
    said: bytes | None = None
    told_at: float = -inf
    times: int = 0
    weak_until: float = -inf
    rest_at: float = inf
    carried: bool = False
    overtaken: float | None = None
    led: float | None = None
    still: tuple[int, float] | None = None

    @property
    def energised(self) -> bool:
        """Return whether it has torque by this driver, or may have had it by the one before."""
        return self.on or self.carried

    def unblock(self) -> None:
        """Let it get torque again, as any other."""
        self.blocked, self.carried = "", False

    def leads(self, goal: ServoGoal, count: int, here: int | None, round_s: float) -> bool:
        """Return whether a goal is where the servo is, or leads on from that `round_s` ago; it would jump there
        otherwise."""
        if here is not None and abs(here - count) <= NEAR:
            return True
        if self.on and self.count is not None:
            return abs(self.count - count) <= STRIDE + FASTEST_CPS * round_s
        return self.on and goal.position_rad == self.led
