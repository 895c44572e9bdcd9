"""The decision about setpoints for servos: a pure function of state, event and time.

When setpoints cease, or report that their sender is lost, the motion ends: the servos hold, and are later released
slowly. The quoted lease is then revoked: setpoints that still quote it keep the servos held, and move nothing.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import inf, isfinite
from typing import Literal

from lbr.drivers.setpoint_gate import SetpointGate, fresh
from lbr.messages.codes import ReasonCode
from lbr.messages.servos import ServoGoal, ServoSetpoint

START = "no setpoint came yet"


@dataclass(frozen=True, slots=True)
class BornSetpoint:
    """A setpoint and the older of its stamp and its arrival."""

    message: ServoSetpoint
    born: float

    @property
    def lease(self) -> str:
        """The lease that it quotes."""
        return self.message.lease

    @property
    def finite(self) -> bool:
        """Return whether all numbers of every goal are finite."""
        return all(_finite(goal) for goal in self.message.goals)

    @property
    def neutral(self) -> Literal[False]:
        """Return False: a goal equal to the position now moves the servo after it has been turned."""
        return False


@dataclass(frozen=True, slots=True)
class ServoGate(SetpointGate[BornSetpoint]):
    """The state. `goals` are in force while it `follows`; only `wanted` servos may have torque.

    `lost_since`: the time at which the servos lost their sender. `halts` counts the received stops. `seen`: there was a
    setpoint.
    """

    reason: str = START
    goals: Mapping[int, ServoGoal] = field(default_factory=dict)
    wanted: frozenset[int] = frozenset()
    lost_since: float | None = None
    estop: bool = False
    lease: str = ""
    born: float = -inf
    halt: int | None = None
    halts: int = 0

    @property
    def follows(self) -> bool:
        """Return whether its goals are in force."""
        return self.setpoint is not None

    @property
    def seen(self) -> bool:
        """Return whether there ever was a setpoint; before the first, torque stays as it was found."""
        return self.born > -inf

    def stopped_since(self, before: "ServoGate") -> bool:
        """Return whether a stop arrived, or the motion ended, since that state."""
        return self.halts != before.halts or (before.follows and not self.follows)


def first(now: float) -> ServoGate:
    """Return the initial state: servos that already have torque have no sender yet."""
    return ServoGate(lost_since=now)


def receive(state: ServoGate, setpoint: ServoSetpoint, born: float, now: float, valid_s: float) -> ServoGate:
    """Return the state after a setpoint of the wired source; `born` is the older of its stamp and its arrival."""
    received = BornSetpoint(setpoint, born)
    verdict = state.judge(received, now, valid_s)
    if verdict == "late":
        return state
    state = _halted(state, setpoint)
    if verdict == "not_finite":
        return _lose(state, "the setpoint holds a value that is not a number", now)
    wanted = frozenset(goal.id for goal in setpoint.goals if goal.torque > 0.0)
    state = replace(state, wanted=wanted, born=born)
    if setpoint.lost:
        return _lose(state, "the mover of the servos is lost", now)
    state = replace(state, lost_since=None)
    if state.estop:
        return replace(state.revoked(setpoint.lease), lease=setpoint.lease)
    if verdict == "revoked":
        return state.closed("the lease of this motion has died; stop, then move again")
    goals = {goal.id: goal for goal in setpoint.goals}
    return replace(state, goals=goals, setpoint=received, lease=setpoint.lease, reason="", code="")


def tick(state: ServoGate, now: float, valid_s: float, absence: str = "", estop: str | None = None) -> ServoGate:
    """Return the state at a later time; `absence` explains a missing source, `estop` an engaged emergency stop."""
    if estop is not None:
        state = replace(ended(state, f"emergency stop: {estop or 'no reason given'}"), estop=True)
    elif state.estop:
        state = replace(state, estop=False, reason="the emergency stop was reset; waiting for a setpoint")
    if absence:
        return _lose(state, absence, now)
    if state.seen and not fresh(state.born, now, valid_s):
        return _lose(state, f"no setpoint within {valid_s:g} s", now, "no_setpoint")
    return state


def strength(state: ServoGate, now: float, hold_s: float, release_s: float) -> float:
    """Return the share of torque that servos keep: 1 with a sender and for `hold_s` after its loss, then down to 0."""
    if state.lost_since is None:
        return 1.0
    fading_s = now - state.lost_since - hold_s
    return 1.0 if fading_s <= 0.0 else max(0.0, 1.0 - fading_s / release_s)


def ended(state: ServoGate, reason: str, code: ReasonCode = "") -> ServoGate:
    """End the current motion, and revoke its lease."""
    return state.closed(reason, state.lease, code)


def _lose(state: ServoGate, reason: str, now: float, code: ReasonCode = "") -> ServoGate:
    if state.lost_since is not None:
        return state
    why = (state.reason, state.code) if state.estop else (reason, code)
    return replace(ended(state, *why), lost_since=now)


def _halted(state: ServoGate, setpoint: ServoSetpoint) -> ServoGate:
    if setpoint.halt == state.halt:
        return state
    return replace(state, halt=setpoint.halt, halts=state.halts + 1)


def _finite(goal: ServoGoal) -> bool:
    numbers = (goal.position_rad, goal.speed_rps, goal.torque)
    return all(number is None or isfinite(number) for number in numbers)
