"""Whether whoever moves the servos can be believed: a pure function of state, event and time.

Setpoints that cease, or say that the mover is lost, end the motion: the servos hold, after a time they let go slowly.
The lease that was quoted then is dead: setpoints that still quote it keep the servos held, and move nothing.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf, isfinite

from lbr.messages.servos import ServoGoal, ServoSetpoint

DEAD_LEASES_KEPT = 256
START = "no setpoint came yet"


@dataclass(frozen=True, slots=True)
class Mover:
    """The state. `goals` are in force while it `follows`; `wanted` are the servos that may have torque at all.

    `lost_since`: nobody cares for the servos since then. `halts` counts the stops that came. `seen`: there was a setpoint.
    """

    goals: Mapping[int, ServoGoal]
    wanted: frozenset[int]
    lost_since: float | None
    reason: str = START
    follows: bool = False
    estop: bool = False
    lease: str = ""
    born: float = -inf
    halt: int | None = None
    halts: int = 0
    dead: tuple[str, ...] = ()

    @property
    def seen(self) -> bool:
        """Whether there ever was a setpoint; before, torque is left as it was found."""
        return self.born > -inf


def first(now: float) -> Mover:
    """Return the state before anything came: nobody cares yet for what may already have torque."""
    return Mover(goals={}, wanted=frozenset(), lost_since=now)


def receive(state: Mover, setpoint: ServoSetpoint, born: float, now: float, valid_s: float) -> Mover:
    """Take a setpoint of the wired source; `born` is the older of its stamp and its arrival."""
    if not _fresh(born, now, valid_s):
        return state
    state = _halted(state, setpoint)
    if not all(_finite(goal) for goal in setpoint.goals):
        return _lose(state, "the setpoint holds what is no number", now)
    wanted = frozenset(goal.id for goal in setpoint.goals if goal.torque > 0.0)
    state = replace(state, wanted=wanted, born=born)
    if setpoint.lost:
        return _lose(state, "whoever moved the servos is lost", now)
    state = replace(state, lost_since=None)
    if state.estop:
        return replace(state, lease=setpoint.lease, dead=_buried(state.dead, setpoint.lease))
    if setpoint.lease in state.dead:
        return replace(state, follows=False, reason="the lease of this motion has died; stop, then move anew")
    goals = {goal.id: goal for goal in setpoint.goals}
    return replace(state, goals=goals, follows=True, lease=setpoint.lease, reason="")


def tick(state: Mover, now: float, valid_s: float, gone: str = "", estop: str | None = None) -> Mover:
    """Let time pass. `gone` says why there is no source; `estop` why the emergency stop is engaged."""
    if estop is not None:
        state = replace(
            state,
            estop=True,
            follows=False,
            reason=f"emergency stop: {estop or 'no reason given'}",
            dead=_buried(state.dead, state.lease),
        )
    elif state.estop:
        state = replace(state, estop=False, reason="the emergency stop was reset; waiting for a setpoint")
    if gone:
        return _lose(state, gone, now)
    if state.seen and not _fresh(state.born, now, valid_s):
        return _lose(state, f"no setpoint within {valid_s:g} s", now)
    return state


def strength(state: Mover, now: float, hold_s: float, release_s: float) -> float:
    """Return how much of their torque the servos keep: all while somebody cares and for `hold_s`, then less and less."""
    if state.lost_since is None:
        return 1.0
    fading_s = now - state.lost_since - hold_s
    return 1.0 if fading_s <= 0.0 else max(0.0, 1.0 - fading_s / release_s)


def ended(state: Mover, reason: str) -> Mover:
    """End the motion under way for a reason of the driver's own: its lease is dead."""
    return replace(state, follows=False, reason=reason, dead=_buried(state.dead, state.lease))


def bury(state: Mover, lease: str) -> Mover:
    """Have a lease dead from the beginning: what was under way before the line was opened does not go on."""
    return replace(state, dead=_buried(state.dead, lease))


def _lose(state: Mover, reason: str, now: float) -> Mover:
    if state.lost_since is not None and not state.follows:
        return state
    since = now if state.lost_since is None else state.lost_since
    said = state.reason if state.estop else reason
    return replace(state, follows=False, lost_since=since, reason=said, dead=_buried(state.dead, state.lease))


def _halted(state: Mover, setpoint: ServoSetpoint) -> Mover:
    if setpoint.halt == state.halt:
        return state
    return replace(state, halt=setpoint.halt, halts=state.halts + 1)


def _buried(dead: tuple[str, ...], lease: str) -> tuple[str, ...]:
    """A hold without a lease cannot die."""
    return dead if not lease or lease in dead else (*dead, lease)[-DEAD_LEASES_KEPT:]


def _finite(goal: ServoGoal) -> bool:
    numbers = (goal.position_rad, goal.speed_rps, goal.torque)
    return all(number is None or isfinite(number) for number in numbers)


def _fresh(born: float, now: float, valid_s: float) -> bool:
    age_s = now - born
    return -valid_s <= age_s < valid_s  # this way round, NaN means late
