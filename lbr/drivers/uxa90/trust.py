"""Whether a position that came is believed: a pure function of what came before. It carries neither id nor checksum.

Believed is what the servo could have reached since it was believed last. Several that cannot be, and nothing of it is
believed any more; several in a row that fit one another, and it is again.
"""

from dataclasses import dataclass, replace
from math import inf
from typing import Literal

from lbr.drivers.uxa90.packets import Answer

Policy = Literal["never", "plausible", "always"]
TOLERANCE = 6
RESTING_CPS, MOVING_CPS = 100.0, 420.0
"""Counts a second: a servo that is to stay somewhere, and one that moves or may be moved by hand."""
FITTING = 4
FITTING_CPS = 60.0
LOSES, GAINS = 3, 5
OLD_S = 2.0
"""Nothing follows from a position so old."""


@dataclass(frozen=True, slots=True)
class Seen:
    """One servo: what is believed (`position`, `load`, `at`), and what came last (`raw`, `raw_at`).

    `streak` counts answers in a row that fit one another, `doubts` those in a row that could not be.
    """

    position: int | None = None
    load: int | None = None
    at: float = -inf
    raw: int | None = None
    raw_at: float = -inf
    trusted: bool = False
    streak: int = 0
    doubts: int = 0
    implausible: int = 0
    reason: str = ""


def judged(seen: Seen, answer: Answer, at: float, policy: Policy, *, moving: bool) -> Seen:
    """Take an answer in. `moving`: the servo was told to go elsewhere, or has no torque."""
    if not answer.possible:
        return _doubted(seen, policy)
    fits = (
        at - seen.raw_at < OLD_S
        and seen.raw is not None
        and abs(answer.position - seen.raw) <= FITTING + FITTING_CPS * (at - seen.raw_at)
    )
    streak = seen.streak + 1 if fits else 1
    raw = replace(seen, raw=answer.position, raw_at=at, streak=streak, reason="")
    if policy != "plausible":
        return _believed(raw, answer, at) if policy == "always" else replace(raw, trusted=False)
    if seen.trusted and seen.position is not None and at - seen.at < OLD_S:
        rate = MOVING_CPS if moving else RESTING_CPS
        if abs(answer.position - seen.position) <= TOLERANCE + rate * (at - seen.at):
            return _believed(raw, answer, at)
        return _doubted(raw, policy)
    return _believed(raw, answer, at) if streak >= GAINS else replace(raw, trusted=False)


def silent(seen: Seen, reason: str) -> Seen:
    """Take in that a servo does not answer: what it says next has to prove itself anew."""
    return replace(seen, trusted=False, streak=0, doubts=0, reason=reason)


def _believed(seen: Seen, answer: Answer, at: float) -> Seen:
    return replace(seen, position=answer.position, load=answer.load, at=at, trusted=True, doubts=0)


def _doubted(seen: Seen, policy: Policy) -> Seen:
    doubts = seen.doubts + 1
    trusted = policy != "never" and seen.trusted and doubts < LOSES
    streak = seen.streak if seen.trusted == trusted else min(seen.streak, 1)
    return replace(seen, doubts=doubts, implausible=seen.implausible + 1, trusted=trusted, streak=streak)
