"""The belief in a position: a pure function of those before. It carries neither id nor checksum.

Believed is what the servo could have reached since it was believed last, and if that is elsewhere, not at the first
word. Several that cannot be, and nothing of it is believed any more; several in a row that fit one another, and it is
again.
"""

from dataclasses import dataclass, replace
from math import inf
from typing import Literal

from lbr.robots.uxa90.driver.packets import Answer

Policy = Literal["never", "plausible", "always"]
TOLERANCE = 6
RESTING_CPS, MOVING_CPS = 40.0, 420.0
"""Counts a second: a servo that is to stay somewhere, and one that moves or may be moved by hand."""
SMALL = 2
"""A step no longer than this is believed at once."""
TOLD_RESTING, TOLD_MOVING = 3, 2
"""The reports in a row that a servo must give of another place, on the same side, unless it moves that way already."""
FITTING_MOVING, FITTING_CPS, FITTING_S = 4, 150.0, 0.1
LOSES, GAINS = 3, 5
OLD_S = 1.0
"""Nothing follows from a position so old."""


@dataclass(frozen=True, slots=True)
class Seen:
    """One servo: what is believed (`position`, `load`, `at`), and what came last (`raw`, `raw_at`).

    `streak` counts answers in a row that fit one another, `doubts` those in a row that could not be, `apart` those in a
    row that were on one side of what is believed (negative: below); `trend` is the side that it moved to last.
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
    """Take an answer in. `moving`: the servo was told to go elsewhere, or has no torque."""
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
    """Take in that a servo does not answer: what it says next has to prove itself again."""
    return replace(seen, trusted=False, streak=0, doubts=0, apart=0, trend=0, reason=reason)


def doubted(seen: Seen) -> Seen:
    """Take in that what came before proves nothing."""
    return replace(seen, streak=0)


def _compared(seen: Seen, answer: Answer, at: float, step: int, *, moving: bool) -> Seen:
    """Judge a step from what is believed."""
    if abs(step) <= SMALL:
        return _believed(replace(seen, apart=0, trend=0), answer, at)
    rate = MOVING_CPS if moving else RESTING_CPS
    if abs(step) > TOLERANCE + rate * (at - seen.at):
        return _doubted(replace(seen, apart=0), "plausible")
    side = 1 if step > 0 else -1
    apart = seen.apart + side if seen.apart * side > 0 else side
    told = TOLD_MOVING if moving else TOLD_RESTING
    if seen.trend == side or abs(apart) >= told:
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
