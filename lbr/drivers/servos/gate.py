"""The trust in a sender of setpoints: a pure function of state, event and time.

Setpoints that cease, or say that their sender is lost, end the motion: the servos hold, and after a time release
slowly. The lease that was quoted then is revoked: setpoints that still quote it keep the servos held, and move nothing.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import inf, isfinite
from typing import Literal

from lbr.drivers.setpoint_gate import SetpointGate, fresh
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
        """Return whether every goal is of finite numbers."""
        return all(_finite(goal) for goal in self.message.goals)

    @property
    def neutral(self) -> Literal[False]:
        """Say no: a goal that stands still today is reached from elsewhere tomorrow."""
        return False


@dataclass(frozen=True, slots=True)
class ServoGate(SetpointGate[BornSetpoint]):
    """The state. `goals` are in force while it `follows`; `wanted` are the servos that may have torque at all.

    `lost_since`: the servos have no sender since then. `halts` counts the stops that came. `seen`: there was a
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
        """Return whether there ever was a setpoint; before, torque is left as it was found."""
        return self.born > -inf

    def stopped_since(self, before: "ServoGate") -> bool:
        """Return whether a stop came since that state, or the end of what was followed then."""
        return self.halts != before.halts or (before.follows and not self.follows)


def first(now: float) -> ServoGate:
    """Return the state before anything came: what may already have torque has no sender yet."""
    return ServoGate(lost_since=now)


def receive(state: ServoGate, setpoint: ServoSetpoint, born: float, now: float, valid_s: float) -> ServoGate:
    """Take a setpoint of the wired source; `born` is the older of its stamp and its arrival."""
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
    return replace(state, goals=goals, setpoint=received, lease=setpoint.lease, reason="")


def tick(state: ServoGate, now: float, valid_s: float, absence: str = "", estop: str | None = None) -> ServoGate:
    """Let time pass. `gone` says why there is no source; `estop` why the emergency stop is engaged."""
    if estop is not None:
        state = replace(ended(state, f"emergency stop: {estop or 'no reason given'}"), estop=True)
    elif state.estop:
        state = replace(state, estop=False, reason="the emergency stop was reset; waiting for a setpoint")
    if absence:
        return _lose(state, absence, now)
    if state.seen and not fresh(state.born, now, valid_s):
        return _lose(state, f"no setpoint within {valid_s:g} s", now)
    return state


def strength(state: ServoGate, now: float, hold_s: float, release_s: float) -> float:
    """Return how much of their torque the servos keep: all while there is a sender and for `hold_s`, then less and
    less."""
    if state.lost_since is None:
        return 1.0
    fading_s = now - state.lost_since - hold_s
    return 1.0 if fading_s <= 0.0 else max(0.0, 1.0 - fading_s / release_s)


def ended(state: ServoGate, reason: str) -> ServoGate:
    """End the motion under way, and revoke its lease."""
    return state.closed(reason, state.lease)


def _lose(state: ServoGate, reason: str, now: float) -> ServoGate:
    if state.lost_since is not None:
        return state
    return replace(ended(state, state.reason if state.estop else reason), lost_since=now)


def _halted(state: ServoGate, setpoint: ServoSetpoint) -> ServoGate:
    if setpoint.halt == state.halt:
        return state
    return replace(state, halt=setpoint.halt, halts=state.halts + 1)


def _finite(goal: ServoGoal) -> bool:
    numbers = (goal.position_rad, goal.speed_rps, goal.torque)
    return all(number is None or isfinite(number) for number in numbers)
