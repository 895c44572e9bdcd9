"""The main board's own motions: each is played once on request, and never again. Pure, without time of its own."""

from collections.abc import Collection
from dataclasses import dataclass, replace
from math import inf
from typing import Literal

from lbr.messages.codes import ReasonCode
from lbr.messages.servos import StoredPlay, StoredState

Phase = Literal["none", "waiting", "playing", "ending", "over", "failed"]


@dataclass(frozen=True, slots=True)
class StoredMotions:
    """`asked` is the newest play, `spent` the highest count that is over, refused, or from before the line was opened.

    waiting ─its packet is written─► playing ─its time is over─► ending ─control is regained─► over
    """

    asked: StoredPlay | None = None
    phase: Phase = "none"
    reason: str = ""
    code: ReasonCode = ""
    until: float = inf
    spent: int = 0
    begun: bool = False

    @property
    def busy(self) -> bool:
        """Return whether the main board moves, so that nothing else may."""
        return self.phase == "playing"

    @property
    def wanted(self) -> bool:
        """Return whether a motion is due to start."""
        return self.phase == "waiting"

    def state(self) -> StoredState | None:
        """Return the public state, or None."""
        if self.asked is None or self.phase == "none":
            return None
        phase = "playing" if self.phase == "ending" else self.phase
        return StoredState(
            slot=self.asked.slot, count=self.asked.count, phase=phase, reason=self.reason, code=self.code
        )


def reopened(state: StoredMotions, reason: str) -> StoredMotions:
    """Return the state after the line was opened: earlier requests are not played."""
    return replace(interrupted(state, reason), begun=False)


def seen(state: StoredMotions, play: StoredPlay | None, slots: Collection[int], *, follows: bool) -> StoredMotions:
    """Return the state after a setpoint; `follows`: the gate has admitted it."""
    if play is None or play.count <= state.spent:
        return state if state.begun else replace(state, begun=True)
    if not state.begun:
        return _refused(replace(state, begun=True), play, "it was asked for before the line was opened")
    if not follows:
        return replace(state, spent=play.count)
    if play.slot not in slots:
        known = ", ".join(map(str, sorted(slots)))
        return _refused(state, play, f"motion {play.slot} of the main board may not be started; only {known} may")
    if state.phase in {"playing", "ending"}:
        return _refused(state, play, "another motion of the main board plays")
    return replace(state, asked=play, phase="waiting", reason="", code="", spent=play.count)


def started(state: StoredMotions, now: float) -> StoredMotions:
    """Return the state after its packet was written."""
    assert state.asked is not None
    return replace(state, phase="playing", until=now + state.asked.duration_s)


def ended(state: StoredMotions, now: float) -> StoredMotions:
    """Return the state at a later time."""
    return replace(state, phase="ending") if state.phase == "playing" and now >= state.until else state


def regained(state: StoredMotions) -> StoredMotions:
    """Return the state when servos can get orders again."""
    return replace(state, phase="over") if state.phase == "ending" else state


def interrupted(state: StoredMotions, reason: str, code: ReasonCode = "") -> StoredMotions:
    """Return the state after an end of the waiting or playing motion."""
    if state.phase not in {"waiting", "playing", "ending"}:
        return state
    return replace(state, phase="failed", reason=reason, code=code)


def _refused(state: StoredMotions, play: StoredPlay, reason: str) -> StoredMotions:
    """Refuse a motion; beside one that plays, the refusal is not reported."""
    if state.phase in {"playing", "ending"}:
        return replace(state, spent=play.count)
    return replace(state, asked=play, phase="failed", reason=reason, code="", spent=play.count)
