"""Transactions with STS3215 servos: protocol 1.0 of lbr, with their control table and SYNC READ."""

import time
from collections.abc import Callable, Collection, Mapping, Sequence
from struct import Struct

from lbr.drivers.servos.contract import SlowState
from lbr.drivers.servos.line import ServoLine
from lbr.drivers.servos.protocol1 import packet
from lbr.drivers.servos.protocol1.bus import ProtocolBus
from lbr_so101 import table
from lbr_so101.table import Motion, motion

PRESENT, PRESENT_BYTES = 56, 6
_PRESENT = Struct("<3H")
STATE, STATE_BYTES = 40, 24
_STATE = Struct("<BxHxxHH6x3HBB")
"""Torque enable, goal, goal speed, torque limit; position, speed, load, voltage, temperature."""


class FeetechBus(ProtocolBus):
    """The bus; one SYNC READ reads all servos, and each answers with error bits of its own."""

    together_errors = True

    def __init__(
        self,
        line: ServoLine,
        *,
        together: bool = True,
        acceleration: int = 0,
        clock: Callable[[], float] = time.monotonic,
        urgent: Callable[[], object] = lambda: False,
    ) -> None:
        super().__init__(line, clock=clock, urgent=urgent)
        self.together = together
        self._acceleration = acceleration

    def error_names(self, error: int) -> tuple[str, ...]:
        """Return the names of error bits."""
        return table.error_names(error)

    def read_motion(self, servo: int, *, tries: int | None = None) -> Motion | None:
        """Return position, speed and load of one servo."""
        status = self.read(servo, PRESENT, PRESENT_BYTES, tries=tries)
        return None if status is None else motion(status.error, *_PRESENT.unpack(status.params))

    def read_together(self, servos: tuple[int, ...]) -> list[Motion | None] | None:
        """Return the same of each servo by one request; those that an absent one has silenced are asked singly."""
        found = self.ask_each(packet.sync_read(PRESENT, PRESENT_BYTES, servos), servos, PRESENT_BYTES)
        if self.cut_short or not found:
            return None
        seen = {one: motion(status.error, *_PRESENT.unpack(status.params)) for one, status in found.items()}
        return [seen[servo] if servo in seen else self._behind(servo, servos, seen) for servo in servos]

    def read_state(self, servo: int, patience_s: float) -> tuple[Motion, SlowState] | None:
        """Return motion, torque, goal, limit and supply of one servo, asked once; None: see `trouble`."""
        status = self.read(servo, STATE, STATE_BYTES, tries=1, patience_s=patience_s)
        if status is None:
            return None
        enabled, goal, speed, limit, *present, tenths, celsius = _STATE.unpack(status.params)
        slow = SlowState(
            at=self._clock(),
            enabled=bool(enabled),
            goal=table.goal_of(goal),
            speed=speed,
            limit=limit,
            voltage_v=tenths / 10.0,
            temperature_c=float(celsius),
        )
        return motion(status.error, *present), slow

    def write_positions(self, goals: Mapping[int, int]) -> None:
        """Give each servo a goal at the same time."""
        self.write_all(table.GOAL.address, {servo: table.goal_bytes(goal) for servo, goal in goals.items()})

    def write_goals(self, goals: Mapping[int, tuple[int, int]]) -> None:
        """Give each servo goal and speed at the same time."""
        self.write_all(table.GOAL.address, {servo: _course(*one) for servo, one in goals.items()})

    def write_limits(self, limits: Mapping[int, int]) -> None:
        """Give each servo its torque limit at the same time."""
        self.write_each(table.LIMIT, limits)

    def torque_off(self, servos: Collection[int]) -> None:
        """Switch the torque of all of them off at the same time."""
        self.write_each(table.TORQUE_ENABLE, dict.fromkeys(servos, 0))

    def torque_on(self, servo: int, speed: int, limit: int) -> int | str:
        """Give a servo torque at its present position, and return that, or why it failed.

        A servo also acknowledges values that it ignores, and a goal alone may switch its torque on. So its goal is read
        back; with another goal, its torque is switched off.
        """
        ends = self.read(servo, table.LOWEST.address, 4)
        here = self.read_motion(servo) if ends is not None else None
        if ends is None or here is None:
            return self.trouble
        lowest, highest = (one.decode(ends.params, table.LOWEST.address) for one in (table.LOWEST, table.HIGHEST))
        if not lowest <= here.position <= highest:
            return f"is at {here.position}, outside its own limits ({lowest} to {highest}); move it by hand"
        block = (
            table.ACCELERATION.encode(self._acceleration) + _course(here.position, speed) + table.LIMIT.encode(limit)
        )
        written = self.write(servo, table.ACCELERATION.address, block)
        goal = self.get(servo, table.GOAL) if written else None
        if goal is None or table.goal_of(goal) != here.position:
            why = (
                self.trouble
                if goal is None
                else f"does not take the position where it is ({here.position}) as its goal"
            )
            self.torque_off((servo,))
            return why
        self.put(servo, table.TORQUE_ENABLE, 1)  # its acknowledgement may be lost: the value that is read back counts
        if self.get(servo, table.TORQUE_ENABLE) != 1:
            self.torque_off((servo,))
            return "does not take its torque"
        return here.position

    def _behind(self, servo: int, servos: Sequence[int], seen: Mapping[int, Motion]) -> Motion | None:
        """Ask a silent servo singly, if an absent one before it in the list may have silenced it."""
        place = servos.index(servo)
        silenced = place > 0 and not any(one in seen for one in servos[place - 1 :])
        return self.read_motion(servo, tries=1) if silenced and not self._urgent() else None


def _course(goal: int, speed: int) -> bytes:
    """Return goal, no time, and speed, in the form of registers 42 to 47."""
    return table.goal_bytes(goal) + b"\0\0" + table.SPEED.encode(speed)
