"""The turns of the robot that lbr replaces, on the same world: fixed power, and an observer that says when to stop.

Its observer of angles looks at the gyro's rate ten times a second, whichever way it turns, sums it up by trapezoids and
stops at the angle. That of headings looks at the compass as often, stops within 3 degrees, and gives up when the way grew
by more than 20 degrees from one look to the next. A stop takes 0.1 to 0.25 s on its way. Both get true values here, where
theirs were noisy.
"""

from random import Random

from tests.models.turns.lockstep import STEP_S, Plant

POWER = 0.2
LOOK_STEPS = 10
LATE_S = (0.1, 0.25)
NEAR_DEG, MISSED_DEG = 3.0, 20.0
LONGEST_S = 40.0


class OpenLoop:
    """A base that turns by these observers."""

    def __init__(self, seed: int) -> None:
        self.plant = Plant(seed)
        self._dice = Random(seed)

    def turn(self, angle_deg: float) -> None:
        """Turn by an angle, clockwise positive."""
        rate_dps = summed_deg = 0.0
        began_deg = self.plant.turned_deg
        for _ in range(round(LONGEST_S / (LOOK_STEPS * STEP_S))):
            if summed_deg >= abs(angle_deg):
                break
            self._push(1.0 if angle_deg >= 0.0 else -1.0, LOOK_STEPS)
            now_deg = self.plant.turned_deg
            before_dps, rate_dps = rate_dps, abs(now_deg - began_deg) / (LOOK_STEPS * STEP_S)
            summed_deg += (before_dps + rate_dps) / 2 * LOOK_STEPS * STEP_S
            began_deg = now_deg
        self._stop(angle_deg)

    def head(self, heading_deg: float) -> None:
        """Turn to a heading the shorter way."""
        clockwise_deg = (heading_deg - self.plant.heading_deg) % 360.0
        sense, before_deg = (1.0 if clockwise_deg <= 180.0 else -1.0), 900.0
        for _ in range(round(LONGEST_S / (LOOK_STEPS * STEP_S))):
            apart_deg = abs((heading_deg - self.plant.heading_deg + 180.0) % 360.0 - 180.0)
            if apart_deg <= NEAR_DEG or apart_deg > before_deg + MISSED_DEG:
                break
            before_deg = apart_deg
            self._push(sense, LOOK_STEPS)
        self._stop(sense)

    def _stop(self, sense: float) -> None:
        self._push(1.0 if sense >= 0.0 else -1.0, round(self._dice.uniform(*LATE_S) / STEP_S))
        self._push(0.0, round(1.0 / STEP_S))

    def _push(self, sense: float, steps: int) -> None:
        for _ in range(steps):
            self.plant.step(POWER * sense, -POWER * sense)
