"""Whether a setpoint may reach the motors: a pure function of state, event and time.

Disarmed is where everything begins and where every doubt ends. Only a fresh zero arms; a setpoint that comes late,
is not finite or loses its source stops the motors, and the lease it quoted is dead for good.
"""

from dataclasses import dataclass, replace
from math import inf, isfinite

DEAD_LEASES_KEPT = 256
START = "waiting for a zero setpoint"


@dataclass(frozen=True, slots=True)
class Setpoint:
    """What was asked of the wheels; `born` is the older of its stamp and its arrival, in monotonic seconds."""

    left: float
    right: float
    lease: str
    born: float

    @property
    def zero(self) -> bool:
        """Both wheels are to stand still."""
        return self.left == 0.0 and self.right == 0.0

    @property
    def finite(self) -> bool:
        """Both powers are numbers."""
        return isfinite(self.left) and isfinite(self.right)


@dataclass(frozen=True, slots=True)
class Inhibit:
    """Why nothing may move now; `fault` tells a mishap from what somebody asked for."""

    reason: str
    fault: bool


@dataclass(frozen=True, slots=True)
class Arming:
    """The state: `setpoint` is in force exactly while it is not None."""

    setpoint: Setpoint | None = None
    reason: str = START
    inhibited: bool = False
    since: float = -inf
    dead: tuple[str, ...] = ()
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
        return self.setpoint is not None and not self.setpoint.zero


def receive(state: Arming, setpoint: Setpoint, now: float, valid_s: float) -> Arming:
    """Take a setpoint from the wired source."""
    if not setpoint.finite:
        return _disarm(_bury(state, setpoint.lease), "the setpoint is not a finite number", now, fault=True)
    if not _fresh(setpoint, now, valid_s) or (not setpoint.zero and setpoint.lease in state.dead):
        return state
    if state.armed:
        return replace(state, setpoint=setpoint)
    if setpoint.zero and not state.inhibited and setpoint.born > state.since:
        return replace(state, setpoint=setpoint, reason="")
    return state


def tick(state: Arming, inhibit: Inhibit | None, now: float, valid_s: float) -> Arming:
    """Let time pass: stop what is inhibited or late."""
    if inhibit is not None:
        if state.armed or not state.inhibited:
            state = _disarm(state, inhibit.reason, now, fault=inhibit.fault)
        return replace(state, inhibited=True, reason=inhibit.reason, since=now)
    if state.setpoint is not None and not _fresh(state.setpoint, now, valid_s):
        state = _disarm(state, f"no setpoint within {valid_s:g} s", now, fault=True)
    if state.inhibited:
        return replace(state, inhibited=False, reason=START)
    return state


def _disarm(state: Arming, reason: str, now: float, *, fault: bool) -> Arming:
    if state.moving:
        assert state.setpoint is not None
        state = replace(_bury(state, state.setpoint.lease), trips=state.trips + fault)
    return replace(state, setpoint=None, reason=f"{reason}; {START}", since=now)


def _bury(state: Arming, lease: str) -> Arming:
    if not lease or lease in state.dead:
        return state
    return replace(state, dead=(*state.dead, lease)[-DEAD_LEASES_KEPT:])


def _fresh(setpoint: Setpoint, now: float, valid_s: float) -> bool:
    age_s = now - setpoint.born
    return -valid_s <= age_s < valid_s  # this way round, NaN means stop
