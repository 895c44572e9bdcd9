"""Backing up to the dock between its two beams. Pure.

Only the left beam: the robot is on the dock's left, so its back swings to its right, and more so the longer that lasts.
Both beams: straight back.
"""

from collections import deque
from dataclasses import dataclass

from lbr.apps.autodock.moves import shortest
from lbr.apps.autodock.view import STAND, Back, GivenUpError, Script, View

NEAR_M = 0.40
BESIDE_M = 0.15
FAR_POWER, NEAR_POWER = 0.15, 0.09
FIRST_DEG, GROWTH_DPS, MOST_DEG, NEAR_DEG = 12.0, 15.0, 35.0, 4.0
GAIN, MOST_STEER_DEG = 0.7, 25.0
LOST_S = 1.2
STUCK_S, STUCK_M = 1.5, 0.015
LONGEST_S = 40.0


@dataclass(frozen=True, slots=True)
class Followed:
    """How it ended. `aside` is where the dock's middle line is from the robot, as it looks: 1 right, -1 left."""

    touched: bool
    why: str
    aside: float = 0.0


def follow(docked_back_m: float) -> Script[Followed]:
    """Drive back between the beams until something stops it; `docked_back_m` is what the rear sensor reads on the dock."""
    view = yield STAND
    course, began = _Course(view, docked_back_m), view.time_s
    while (end := course.see(view)) is None and view.time_s - began < LONGEST_S:
        view = yield course.back()
    yield STAND
    return end or Followed(touched=False, why="it takes too long", aside=course.aside)


class _Course:
    """What was seen on the way."""

    def __init__(self, view: View, docked_back_m: float) -> None:
        self.aside = 0.0
        self._docked_back_m = docked_back_m
        self._view = view
        self._seen_at = view.time_s
        self._aside_since = view.time_s
        self._way: deque[tuple[float, float]] = deque()

    def see(self, view: View) -> Followed | None:
        """Take in what is seen, and say how it ended if it did."""
        self._view = view
        self._note_beams(view)
        if view.charging or "power" in view.beams:
            return Followed(touched=True, why="")
        if view.ending is not None:
            if view.ending.final:
                raise GivenUpError(view.ending.text)
            return Followed(touched=False, why=view.ending.text, aside=self.aside)
        left_m = self._left_m(view)
        if view.time_s - self._seen_at > LOST_S and left_m > NEAR_M / 2:
            return Followed(touched=False, why="the dock's beams were lost", aside=self.aside)
        if self.aside and left_m < BESIDE_M and view.time_s - self._aside_since > LOST_S / 2:
            return Followed(touched=False, why="it came beside the dock", aside=self.aside)
        if self._stuck(view):
            near = left_m < BESIDE_M
            return Followed(touched=near, why="" if near else "something is in the way", aside=self.aside)
        return None

    def back(self) -> Back:
        """Return how to go on."""
        view, near = self._view, self._left_m(self._view) < NEAR_M
        lasted_s = view.time_s - self._aside_since
        most_deg = NEAR_DEG if near else MOST_DEG
        wanted_deg = -self.aside * min(most_deg, FIRST_DEG + GROWTH_DPS * lasted_s)
        missing_deg = shortest(wanted_deg - view.direction_deg)
        steer_deg = max(-MOST_STEER_DEG, min(MOST_STEER_DEG, GAIN * missing_deg))
        return Back(NEAR_POWER if near else FAR_POWER, round(steer_deg, 1))

    def _note_beams(self, view: View) -> None:
        beams = view.beams & {"left", "right"}
        if not beams:
            return
        self._seen_at = view.time_s
        aside = 0.0 if len(beams) == 2 else 1.0 if "left" in beams else -1.0
        if aside != self.aside:
            self.aside, self._aside_since = aside, view.time_s

    def _left_m(self, view: View) -> float:
        return 9.9 if view.back_m is None else view.back_m - self._docked_back_m

    def _stuck(self, view: View) -> bool:
        if view.back_m is None:
            return False
        self._way.append((view.time_s, view.back_m))
        while view.time_s - self._way[0][0] > STUCK_S:
            self._way.popleft()
        whole = view.time_s - self._way[0][0] > STUCK_S * 0.8
        return whole and max(m for _, m in self._way) - min(m for _, m in self._way) < STUCK_M
