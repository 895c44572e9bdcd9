"""Whether a setpoint may reach the wheels: a pure function of state, event and time.

Disarmed is where everything begins and where every doubt ends. Only a fresh zero arms; a setpoint that comes late,
is not finite or loses its source stops the motors, and the lease it quoted is dead for good.
"""

from dataclasses import dataclass, replace
from math import inf, isfinite

from lbr.drivers.setpoint_gate import SetpointGate, fresh

START = "waiting for a zero setpoint"


@dataclass(frozen=True, slots=True)
class Setpoint:
    """What was asked of the wheels; `born` is the older of its stamp and its arrival, in monotonic seconds."""

    left: float
    right: float
    lease: str
    born: float

    @property
    def neutral(self) -> bool:
        """Both wheels are to stand still."""
        return self.left == 0.0 and self.right == 0.0

    @property
    def finite(self) -> bool:
        """Both powers are numbers."""
        return isfinite(self.left) and isfinite(self.right)


@dataclass(frozen=True, slots=True)
class Inhibit:
    """Why nothing may move now; `fault` tells a mishap from what was asked for."""

    reason: str
    fault: bool


@dataclass(frozen=True, slots=True)
class Arming(SetpointGate[Setpoint]):
    """The state. Only a zero born after `since` arms; `trips` counts the motions that a mishap ended."""

    reason: str = START
    inhibited: bool = False
    since: float = -inf
    trips: int = 0

    @property
    def armed(self) -> bool:
        """Whether the next fresh setpoint will be applied."""
        return self.setpoint is not None

    @property
    def applied(self) -> tuple[float, float]:
        """Power of the left and the right wheel."""
        return (self.setpoint.left, self.setpoint.right) if self.setpoint else (0.0, 0.0)

    @property
    def moving(self) -> bool:
        """Whether a power other than zero is in force."""
        return self.setpoint is not None and not self.setpoint.neutral


def receive(state: Arming, setpoint: Setpoint, now: float, valid_s: float) -> Arming:
    """Take a setpoint from the wired source."""
    verdict = state.judge(setpoint, now, valid_s)
    if verdict == "not_finite":
        return _disarm(state.revoked(setpoint.lease), "the setpoint is not a finite number", now, fault=True)
    arms = setpoint.neutral and not state.inhibited and setpoint.born > state.since
    if verdict == "passes" and (state.armed or arms):
        return replace(state, setpoint=setpoint, reason="")
    return state


def tick(state: Arming, inhibit: Inhibit | None, now: float, valid_s: float) -> Arming:
    """Let time pass: stop what is inhibited or late."""
    if inhibit is not None:
        if state.armed or not state.inhibited:
            state = _disarm(state, inhibit.reason, now, fault=inhibit.fault)
        return replace(state, inhibited=True, reason=inhibit.reason, since=now)
    if state.setpoint is not None and not fresh(state.setpoint.born, now, valid_s):
        state = _disarm(state, f"no setpoint within {valid_s:g} s", now, fault=True)
    if state.inhibited:
        return replace(state, inhibited=False, reason=START)
    return state


def _disarm(state: Arming, reason: str, now: float, *, fault: bool) -> Arming:
    moved = state.setpoint.lease if state.setpoint is not None and state.moving else ""
    trips = state.trips + (fault and state.moving)
    return replace(state.closed(f"{reason}; {START}", moved), since=now, trips=trips)
