"""Backing up to the dock between its two beams. Pure.

With only the left beam in sight the robot is on the dock's left: its back swings to its right, more the longer that
lasts. With both beams it goes straight back. A compass is wrong by some degrees, more near a charger: the deviation
from both beams is learnt as its error.
"""

from collections import deque
from dataclasses import dataclass

from lbr.messages.codes import Code
from lbr.robots.lbr.beacon.moves import shortest
from lbr.robots.lbr.beacon.view import STAND, Back, GivenUpError, Script, View

NEAR_M = 0.40
LAST_M = 0.15
FAR_POWER, NEAR_POWER = 0.15, 0.09
FIRST_DEG, GROWTH_DPS = 8.0, 12.0
MOST_DEG, NEAR_DEG, LAST_DEG = 35.0, 8.0, 4.0
LEARN_DPS, MOST_LEARNT_DEG = 2.5, 22.0
GAIN, MOST_STEER_DEG = 1.2, 30.0
LOST_S = 1.2
STANDS_S, STANDS_M = 1.5, 0.015
LONGEST_S = 40.0


@dataclass(frozen=True, slots=True)
class Followed:
    """The end of following. `aside` is the side of the dock's middle line, as the robot looks: 1 right, -1 left."""

    touched: bool
    why: str
    aside: float = 0.0
    code: Code = "done"


def follow(docked_back_m: float) -> Script[Followed]:
    """Drive back between the beams until something stops it; on the dock the rear sensor reads `docked_back_m`."""
    view = yield STAND
    course, began = _Course(view, docked_back_m), view.time_s
    while (end := course.see(view)) is None and view.time_s - began < LONGEST_S:
        view = yield course.back()
    yield STAND
    return end or Followed(touched=False, why="it takes too long", aside=course.aside, code="timeout")


class _Course:
    """The course by the sightings on the way."""

    def __init__(self, view: View, docked_back_m: float) -> None:
        self.aside = 0.0
        self._docked_back_m = docked_back_m
        self._view = view
        self._seen_at = view.time_s
        self._aside_since = view.time_s
        self._error_deg = 0.0
        self._was_between = False
        self._way: deque[tuple[float, float]] = deque()

    def see(self, view: View) -> Followed | None:
        """Add a view; return the end, if it is reached."""
        if self._was_between:
            learnt_deg = self._error_deg - self.aside * LEARN_DPS * (view.time_s - self._view.time_s)
            self._error_deg = max(-MOST_LEARNT_DEG, min(MOST_LEARNT_DEG, learnt_deg))
        self._view = view
        self._note_beams(view)
        if view.charging or "power" in view.beams:
            return Followed(touched=True, why="")
        if view.ending is not None:
            if view.ending.final:
                raise GivenUpError(view.ending.text, view.ending.code)
            return Followed(touched=False, why=view.ending.text, aside=self.aside, code=view.ending.code)
        left_m = self._left_m(view)
        if view.time_s - self._seen_at > LOST_S and left_m > NEAR_M / 2:
            return Followed(touched=False, why="the dock's beams were lost", aside=self.aside, code="lost")
        if self._stands(view) and left_m < LAST_M:
            return Followed(touched=True, why="")
        return None

    def back(self) -> Back:
        """Return the next action."""
        view, left_m = self._view, self._left_m(self._view)
        near = left_m < NEAR_M
        most_deg = LAST_DEG if left_m < LAST_M else NEAR_DEG if near else MOST_DEG
        lasted_s = view.time_s - self._aside_since
        wanted_deg = self._error_deg - self.aside * min(most_deg, FIRST_DEG + GROWTH_DPS * lasted_s)
        missing_deg = shortest(wanted_deg - view.direction_deg)
        steer_deg = max(-MOST_STEER_DEG, min(MOST_STEER_DEG, GAIN * missing_deg))
        return Back(NEAR_POWER if near else FAR_POWER, round(steer_deg, 1))

    def _note_beams(self, view: View) -> None:
        beams = view.beams & {"left", "right"}
        if not beams:
            return
        self._seen_at = view.time_s
        self._was_between = self._was_between or len(beams) == 2
        aside = 0.0 if len(beams) == 2 else 1.0 if "left" in beams else -1.0
        if aside != self.aside:
            self.aside, self._aside_since = aside, view.time_s

    def _left_m(self, view: View) -> float:
        return 9.9 if view.back_m is None else view.back_m - self._docked_back_m

    def _stands(self, view: View) -> bool:
        """Return whether it has not come any nearer for a while."""
        if view.back_m is None:
            return False
        self._way.append((view.time_s, view.back_m))
        while view.time_s - self._way[0][0] > STANDS_S:
            self._way.popleft()
        whole = view.time_s - self._way[0][0] > STANDS_S * 0.8
        return whole and max(m for _, m in self._way) - min(m for _, m in self._way) < STANDS_M
