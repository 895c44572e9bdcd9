"""The gate between setpoints and wheels: a pure function of state, event and time.

It begins disarmed, and every doubt disarms it. Only a fresh zero arms. A setpoint that is late, not finite or without a
source stops the motors and revokes its lease for good.
"""

from dataclasses import dataclass, replace
from math import inf, isfinite, nan

from lbr.drivers.setpoint_gate import SetpointGate, fresh
from lbr.messages.codes import ReasonCode
from lbr.messages.motors import RESTS_S

START = "waiting for a zero setpoint"


@dataclass(frozen=True, slots=True)
class Setpoint:
    """The requested power of each motor; `born` is the older of its stamp and its arrival, in monotonic seconds.

    `unnamed` is a motor without a power in the message, whose power is NaN. `begun` is the start of its motion, for a
    zero its own time; NaN: unknown.
    """

    powers: tuple[float, ...]
    lease: str
    born: float
    unnamed: str = ""
    begun: float = nan

    @property
    def neutral(self) -> bool:
        """Return whether all powers are zero."""
        return all(power == 0.0 for power in self.powers)

    @property
    def finite(self) -> bool:
        """Return whether all powers are finite."""
        return all(map(isfinite, self.powers))

    @property
    def stays(self) -> bool:
        """Return whether it is a zero that stays in force at rest."""
        return self.neutral and isfinite(self.begun)


@dataclass(frozen=True, slots=True)
class Inhibit:
    """Why nothing may move now; `fault` distinguishes a mishap from a request."""

    reason: str
    fault: bool


@dataclass(frozen=True, slots=True)
class Arming(SetpointGate[Setpoint]):
    """The state of `count` motors. Only a zero born after `since` arms; `trips` counts motions ended by a mishap."""

    count: int = 2
    reason: str = START
    inhibited: bool = False
    since: float = -inf
    trips: int = 0

    @property
    def armed(self) -> bool:
        """Return whether the next fresh setpoint will be applied."""
        return self.setpoint is not None

    @property
    def applied(self) -> tuple[float, ...]:
        """Power of each motor."""
        return self.setpoint.powers if self.setpoint else (0.0,) * self.count

    @property
    def moving(self) -> bool:
        """Return whether a power other than zero is in force."""
        return self.setpoint is not None and not self.setpoint.neutral

    @property
    def rests(self) -> bool:
        """Return whether a zero is in force that stays."""
        return self.setpoint is not None and self.setpoint.stays


def receive(state: Arming, setpoint: Setpoint, now: float, valid_s: float) -> Arming:
    """Return the state after a setpoint from the wired source."""
    verdict = state.judge(setpoint, now, valid_s)
    missed = verdict == "passes" and not setpoint.neutral and _begun_unseen(state, setpoint, now, valid_s)
    if missed or verdict == "not_finite":
        unnamed = f"the setpoint gives motor '{setpoint.unnamed}' no power: drive and driver know other motors"
        why = unnamed if setpoint.unnamed else "the setpoint is not a finite number"
        why = "the beginning of this motion was missed" if missed else why
        return _disarm(state.revoked(setpoint.lease), why, now, fault=True)
    arms = setpoint.neutral and not state.inhibited and setpoint.born > state.since
    if verdict == "passes" and (state.armed or arms):
        return replace(state, setpoint=setpoint, reason="", code="")
    return state


def tick(state: Arming, inhibit: Inhibit | None, now: float, valid_s: float) -> Arming:
    """Return the state at a later time: inhibited or late motion stops."""
    if inhibit is not None:
        stopped = _disarm(state, inhibit.reason, now, fault=inhibit.fault)
        return replace(stopped, inhibited=True, reason=inhibit.reason)
    lives_s = RESTS_S if state.rests else valid_s
    if state.setpoint is not None and not fresh(state.setpoint.born, now, lives_s):
        state = _disarm(state, f"no setpoint within {lives_s:g} s", now, fault=True, code="no_setpoint")
    if state.inhibited:
        return replace(state, inhibited=False, reason=START)
    return state


def _begun_unseen(state: Arming, setpoint: Setpoint, now: float, valid_s: float) -> bool:
    """Return whether a motion follows a zero that stayed for long, and may be far up its ramp."""
    zero = state.setpoint
    long_ago = zero is not None and zero.stays and not fresh(zero.born, now, valid_s)
    return long_ago and not fresh(setpoint.begun, now, valid_s)


def _disarm(state: Arming, reason: str, now: float, *, fault: bool, code: ReasonCode = "") -> Arming:
    moved = state.setpoint.lease if state.setpoint is not None and state.moving else ""
    trips = state.trips + (fault and state.moving)
    return replace(state.closed(f"{reason}; {START}", moved, code), since=now, trips=trips)
