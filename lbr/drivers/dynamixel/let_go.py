"""The guard's program: after the driver's death the servos hold where they are, then their torque fades, then it is off.

`python -m lbr.drivers.dynamixel.let_go TTY_FD PIPE_FD DRIVER_PIDFD SILENCE_MS WORDS_FD WORDS_HEX BAUD MARGIN_S HOLD_S
RELEASE_S ID...`. It keeps the line locked only while it speaks: the moment a new driver has it, it is done.
"""

import sys
import termios
import time
from collections import deque
from collections.abc import Callable, Collection
from contextlib import suppress

from lbr.drivers.dynamixel import table
from lbr.drivers.dynamixel.bus import Bus
from lbr.drivers.dynamixel.line import ServoLine
from lbr.drivers.last_word import SURE, TakenError, alone, drop_output, share
from lbr.drivers.watch import outlast

STEP_S = 0.05


class LastMover:
    """Holds, fades and lets go. `sleep` and `clock` are for tests."""

    def __init__(
        self,
        bus: Bus,
        tty: int,
        servos: Collection[int],
        sleep: Callable[[float], None] = time.sleep,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._bus = bus
        self._tty = tty
        self._servos = servos
        self._sleep = sleep
        self._clock = clock
        self._limits: dict[int, int] = {}
        self._unheard = deque(servos)

    def act(self, hold_s: float, release_s: float) -> None:
        """Return when nothing has torque any more, or another driver took the line."""
        share(self._tty)
        with suppress(TakenError, OSError, termios.error):
            with alone(self._tty):
                self._hold(len(self._unheard))
            if self._limits or 0 < len(self._unheard) < len(self._servos):
                self._wait(hold_s)
                self._fade(release_s)

    def _hold(self, most: int) -> None:
        """Give so many servos that were not heard yet, if they have torque, the place where they are for their goal."""
        goals = {}
        for servo in [self._unheard.popleft() for _ in range(min(most, len(self._unheard)))]:
            status = self._bus.read(servo, table.TORQUE_ENABLE.address, 20, tries=1)
            if status is None:
                self._unheard.append(servo)
            elif table.TORQUE_ENABLE.decode(status.params, 24):
                self._limits[servo] = table.TORQUE_LIMIT.decode(status.params, 24)
                goals[servo] = _goal(status.params)
        self._bus.write_all(table.GOAL_POSITION.address, goals)

    def _wait(self, hold_s: float) -> None:
        until = self._clock() + hold_s
        while (left_s := until - self._clock()) > 0.0:
            with alone(self._tty):
                self._bus.leftover()  # notices a line that is gone
                self._hold(1)
            self._sleep(min(STEP_S, left_s))

    def _fade(self, release_s: float) -> None:
        """Take the torque away slowly; at once from who was not heard in all that time, but hears perhaps."""
        began = self._clock()
        while (strength := 1.0 - (self._clock() - began) / release_s) > 0.0:
            faded = {servo: max(1, round(limit * strength)) for servo, limit in self._limits.items() if limit}
            with alone(self._tty):
                blocks = {servo: table.TORQUE_LIMIT.encode(limit) for servo, limit in faded.items()}
                self._bus.write_all(table.TORQUE_LIMIT.address, blocks)
            self._sleep(STEP_S)
        for _ in range(SURE):
            with alone(self._tty):
                self._bus.write_all(table.TORQUE_ENABLE.address, dict.fromkeys(self._servos, b"\0"))
            self._sleep(STEP_S / SURE)


def _goal(block: bytes) -> bytes:
    """Return the goal that holds a servo where it is, out of what was read from TORQUE_ENABLE on."""
    first = table.TORQUE_ENABLE.address
    registers = (table.PRESENT_POSITION, table.PRESENT_SPEED, table.GOAL_POSITION)
    return table.GOAL_POSITION.encode(table.holding_goal(*(one.decode(block, first) for one in registers)))


def main(words: list[str]) -> None:
    """Run as the docstring of this module says."""
    tty, pipe, driver, silence_ms, words_fd = (int(word) for word in words[:5])
    last = bytes.fromhex(words[5]) if words[5] != "-" else b""
    baud, margin_s, hold_s, release_s = int(words[6]), *(float(word) for word in words[7:10])
    servos = [int(word) for word in words[10:]]
    line = ServoLine(tty, "of the servos", baud, margin_s=margin_s)
    if outlast(pipe, driver, silence_ms, words_fd, last):
        LastMover(Bus(line), tty, servos).act(hold_s, release_s)
        drop_output(tty)


if __name__ == "__main__":
    main(sys.argv[1:])
