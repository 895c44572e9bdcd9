"""The trust in a position: a pure function of those before. A position carries neither id nor checksum.

A position is trusted if the servo could have reached it since the last trusted one; a large step needs confirmation.
After several impossible positions no position of the servo is trusted. Several in a row that fit one another restore
trust.
"""

from dataclasses import dataclass, replace
from math import inf
from typing import Literal

from lbr.robots.uxa90.driver.packets import Answer

Policy = Literal["never", "plausible", "always"]
TOLERANCE = 6
RESTING_CPS, MOVING_CPS = 40.0, 420.0
"""The speed limits in counts a second: of a servo that stays, and of one that moves or may be moved by hand."""
SMALL = 2
"""The largest step that is trusted at once."""
CONFIRM_RESTING, CONFIRM_MOVING = 3, 2
"""The reports in a row of another position, on the same side, that a servo must give unless it moves that way already.
"""
FITTING_MOVING, FITTING_CPS, FITTING_S = 4, 150.0, 0.1
LOSES, GAINS = 3, 5
OLD_S = 1.0
"""The age from which a position allows no comparison."""


@dataclass(frozen=True, slots=True)
class Seen:
    """One servo: the trusted values (`position`, `load`, `at`), and the last ones (`raw`, `raw_at`).

    `streak` counts successive answers that fit one another, `doubts` successive impossible ones. `apart` counts
    successive ones on one side of the trusted position (negative: below); `trend` is the side of its last move.
    """

    position: int | None = None
    load: int | None = None
    at: float = -inf
    raw: int | None = None
    raw_at: float = -inf
    trusted: bool = False
    streak: int = 0
    doubts: int = 0
    apart: int = 0
    trend: int = 0
    implausible: int = 0
    reason: str = ""


def judged(seen: Seen, answer: Answer, at: float, policy: Policy, *, moving: bool) -> Seen:
    """Add an answer. `moving`: the servo has a new goal, or no torque."""
    if not answer.possible:
        return _doubted(seen, policy)
    streak = seen.streak + 1 if _fits(seen, answer, at, moving=moving) else 1
    raw = replace(seen, raw=answer.position, raw_at=at, streak=streak, reason="")
    if policy != "plausible":
        return _believed(raw, answer, at) if policy == "always" else replace(raw, trusted=False)
    if seen.trusted and seen.position is not None and at - seen.at < OLD_S:
        return _compared(raw, answer, at, answer.position - seen.position, moving=moving)
    return _believed(raw, answer, at) if streak >= GAINS else replace(raw, trusted=False)


def silent(seen: Seen, reason: str) -> Seen:
    """Note that a servo does not answer: its next answers must earn trust again."""
    return replace(seen, trusted=False, streak=0, doubts=0, apart=0, trend=0, reason=reason)


def doubted(seen: Seen) -> Seen:
    """Note that earlier answers prove nothing."""
    return replace(seen, streak=0)


def _compared(seen: Seen, answer: Answer, at: float, step: int, *, moving: bool) -> Seen:
    """Judge a step from the trusted position."""
    if abs(step) <= SMALL:
        return _believed(replace(seen, apart=0, trend=0), answer, at)
    rate = MOVING_CPS if moving else RESTING_CPS
    if abs(step) > TOLERANCE + rate * (at - seen.at):
        return _doubted(replace(seen, apart=0), "plausible")
    side = 1 if step > 0 else -1
    apart = seen.apart + side if seen.apart * side > 0 else side
    needed = CONFIRM_MOVING if moving else CONFIRM_RESTING
    if seen.trend == side or abs(apart) >= needed:
        return _believed(replace(seen, apart=0, trend=side), answer, at)
    return replace(seen, apart=apart)


def _fits(seen: Seen, answer: Answer, at: float, *, moving: bool) -> bool:
    if seen.raw is None or at - seen.raw_at >= OLD_S:
        return False
    within = FITTING_MOVING + FITTING_CPS * min(FITTING_S, at - seen.raw_at) if moving else SMALL + 1
    return abs(answer.position - seen.raw) <= within


def _believed(seen: Seen, answer: Answer, at: float) -> Seen:
    return replace(seen, position=answer.position, load=answer.load, at=at, trusted=True, doubts=0)


def _doubted(seen: Seen, policy: Policy) -> Seen:
    doubts = seen.doubts + 1
    trusted = policy != "never" and seen.trusted and doubts < LOSES
    streak = seen.streak if seen.trusted == trusted else min(seen.streak, 1)
    return replace(seen, doubts=doubts, implausible=seen.implausible + 1, trusted=trusted, streak=streak)
