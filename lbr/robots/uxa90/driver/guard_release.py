"""The guard's program for a UXA-90: the servos hold, then their motors are shorted, then they are released.

For its arguments, with the row's `settle_s` at the end, see `lbr.drivers.servos.guard_release`. Servos hold their last
goal by themselves, which is never more than a step away. PC control is taken at once, to end a motion of the main board
and to have later packets passed on. It asks servos nothing.
"""

import os
import select
import sys
from collections.abc import Collection, Sequence

from lbr.drivers.servos.guard_release import run
from lbr.robots.uxa90.driver.frames import TAKE_CONTROL
from lbr.robots.uxa90.driver.packets import BREAK_ALL, passive


class BoardRelease:
    """The orders to the main board and its servos."""

    blind = True

    def __init__(self, line: int, servos: Collection[int], settle_s: float) -> None:
        self.least_hold_s = settle_s
        self._line = line
        self._servos = servos

    def hold(self) -> bool:
        """Take PC control; the servos hold by themselves."""
        os.write(self._line, TAKE_CONTROL)
        return True

    def keep(self) -> None:
        """Discard the input; raise OSError when the line is gone."""
        if select.select([self._line], [], [], 0.0)[0] and not os.read(self._line, 4096):
            raise OSError("end of file")

    def prepare(self) -> float:
        """Take PC control again: the main board may have been without power meanwhile."""
        os.write(self._line, TAKE_CONTROL)
        return self.least_hold_s

    def fade(self, _strength: float) -> None:
        """Short the motors: they then turn slowly under their load."""
        self.keep()
        os.write(self._line, BREAK_ALL)

    def off(self) -> None:
        """Switch their torque off."""
        os.write(self._line, b"".join(passive(servo) for servo in self._servos))


def released(line: int, servos: list[int], words: Sequence[str]) -> BoardRelease:
    """Return the release for these servos, with the time to take control."""
    return BoardRelease(line, servos, float(words[0]))


if __name__ == "__main__":
    run(sys.argv[1:], released)
