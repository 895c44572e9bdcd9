"""The units of AX-12A servos, and how they latch a fault: the servo sets its own torque limit to 0."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from lbr.drivers.dynamixel import table
from lbr.drivers.dynamixel.packet import error_names
from lbr.drivers.servos.contract import Seen

if TYPE_CHECKING:  # a guard's program imports this, and does no setup
    from lbr.drivers.dynamixel.setup import Kept

ALL_BITS = 0x7F


class Ax12:
    """The model for `lbr.drivers.servos.contract.ServoModel`; `kept` returns a servo's EEPROM values."""

    full_torque = table.FULL_TORQUE
    position_raw = staticmethod(table.position_raw)
    position_rad = staticmethod(table.position_rad)
    speed_raw = staticmethod(table.speed_raw)
    torque_raw = staticmethod(table.torque_raw)
    holding_goal = staticmethod(table.holding_goal)
    faults = staticmethod(error_names)

    def __init__(self, kept: "Callable[[int], Kept | None]" = lambda _servo: None) -> None:
        self._kept = kept

    def most_torque(self, servo: int) -> int:
        """Return the highest torque limit that this servo may have."""
        kept = self._kept(servo)
        return kept.max_torque if kept else table.FULL_TORQUE

    def latched(self, servo: int, seen: Seen) -> tuple[str, ...]:
        """Return the faults that keep a servo without torque until it is recovered."""
        if seen.slow is None or seen.slow.limit:
            return ()
        kept = self._kept(servo)
        return error_names(seen.error & (kept.shutdown if kept else ALL_BITS)) or ("shutdown",)
