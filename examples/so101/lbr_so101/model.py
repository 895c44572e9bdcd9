"""The meaning of STS3215 servos' numbers, and the faults that keep one without torque."""

from collections.abc import Callable

from lbr.drivers.servos.contract import Seen
from lbr_so101 import table
from lbr_so101.setup import Kept

UNLOADING = 0x2C
"""The faults that switch a servo's torque off by the factory's setting: temperature, current, overload."""
NEAR_STEPS = 30
"""A loaded servo rests up to 2.6 degrees beside its goal."""


class Sts3215:
    """See `lbr.drivers.servos.contract.ServoModel`; `kept` returns the values that a servo keeps without power."""

    full_torque = table.FULL_TORQUE
    position_rad = staticmethod(table.position_rad)
    faults = staticmethod(table.error_names)

    def __init__(self, kept: Callable[[int], Kept | None] = lambda _servo: None) -> None:
        self._kept = kept

    def position_raw(self, angle_rad: float) -> int:
        """Return the position nearest to an angle."""
        return max(0, min(table.LAST_STEP, table.CENTRE + round(angle_rad / table.RAD_PER_STEP)))

    def speed_raw(self, speed_rps: float | None) -> int:
        """Return the speed to write; None is the greatest."""
        if speed_rps is None:
            return table.FASTEST
        return max(1, min(table.FASTEST, round(speed_rps / table.RAD_PER_STEP)))

    def torque_raw(self, fraction: float) -> int:
        """Return the torque limit of a fraction."""
        return max(0, min(table.FULL_TORQUE, round(fraction * table.FULL_TORQUE)))

    def holding_goal(self, position: int, speed: int, goal: int) -> int:
        """Return its own goal while it rests near that, otherwise its position."""
        return goal if speed == 0 and abs(goal - position) <= NEAR_STEPS else position

    def most_torque(self, servo: int) -> int:
        """Return the highest torque limit that this servo may get."""
        kept = self._kept(servo)
        return kept.max_torque if kept else table.FULL_TORQUE

    def latched(self, servo: int, seen: Seen) -> tuple[str, ...]:
        """Return the faults for which it has switched off its own torque, or most of it."""
        kept = self._kept(servo)
        return table.error_names(seen.error & ((kept.unloading if kept else UNLOADING) | table.OVERLOAD))
