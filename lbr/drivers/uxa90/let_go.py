"""The guard's program: after the driver's death the servos hold, then their motors are shorted, then they are let go.

`python -m lbr.drivers.uxa90.let_go TTY_FD PIPE_FD DRIVER_PIDFD SILENCE_MS WORDS_FD WORDS_HEX HOLD_S RELEASE_S
SETTLE_S ID...`
Servos hold by themselves what they were told last, which is never more than a step away. PC control is taken at once:
a motion that the main board may play is to end, and what is said later is to be passed on. It reads nothing, and has
the line locked only while it speaks: the moment a new driver has it, it is done. It says nothing where the driver had
nothing with torque.
"""

import os
import select
import sys
import termios
import time
from collections.abc import Callable, Collection
from contextlib import suppress

from lbr.drivers.last_word import SURE, TakenError, alone, drop_output, share
from lbr.drivers.uxa90.frames import TAKE_CONTROL
from lbr.drivers.uxa90.packets import BREAK_ALL, passive
from lbr.drivers.watch import TURNING, outlasted

STEP_S = 0.1


class LastWord:
    """Holds, brakes and lets go. `sleep` and `clock` are for tests."""

    def __init__(
        self,
        tty: int,
        servos: Collection[int],
        settle_s: float,
        sleep: Callable[[float], None] = time.sleep,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._tty = tty
        self._servos = servos
        self._settle_s = settle_s
        self._sleep = sleep
        self._clock = clock

    def act(self, hold_s: float, release_s: float) -> None:
        """Return when nothing has torque any more, or another driver took the line."""
        share(self._tty)
        with suppress(TakenError, OSError, termios.error):
            self._say(TAKE_CONTROL)
            self._wait(max(hold_s, self._settle_s))
            self._say(TAKE_CONTROL)
            self._wait(self._settle_s)
            self._say(BREAK_ALL)
            self._wait(release_s, lambda: self._say(BREAK_ALL))
            for _ in range(SURE):
                self._say(b"".join(passive(servo) for servo in self._servos))
                self._sleep(STEP_S)

    def _say(self, data: bytes) -> None:
        with alone(self._tty):
            os.write(self._tty, data)

    def _wait(self, seconds: float, again: Callable[[], None] = lambda: None) -> None:
        """Wait, as long as no new driver has the line."""
        until = self._clock() + seconds
        while (left_s := until - self._clock()) > 0.0:
            self._sleep(min(STEP_S, left_s))
            with alone(self._tty):
                self._look()
            again()

    def _look(self) -> None:
        """Throw away what has come in; raise OSError when the line is gone."""
        if select.select([self._tty], [], [], 0.0)[0] and not os.read(self._tty, 4096):
            raise OSError("end of file")


def main(words: list[str]) -> None:
    """Run as the docstring of this module says."""
    tty, pipe, driver, silence_ms, words_fd = (int(word) for word in words[:5])
    last = bytes.fromhex(words[5]) if words[5] != "-" else b""
    hold_s, release_s, settle_s = (float(word) for word in words[6:9])
    servos = [int(word) for word in words[9:]]
    if outlasted(pipe, driver, silence_ms, words_fd, last) == TURNING:
        LastWord(tty, servos, settle_s).act(hold_s, release_s)
        drop_output(tty)


if __name__ == "__main__":
    main(sys.argv[1:])
