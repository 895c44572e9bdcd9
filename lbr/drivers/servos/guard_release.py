"""The guard's program: after the driver's death the servos hold where they are, then their torque fades, then it is
off.

`python -m PROGRAM LINE_FD PIPE_FD DRIVER_PIDFD SILENCE_MS WORDS_FD WORDS_HEX HOLD_S RELEASE_S ID,ID… [MORE…]`, where
PROGRAM is a module of the driver's that calls `run`. It keeps the line locked only while it speaks: the moment a new
driver has it, it is done. Imports little, as `run`'s caller should: the guard is started while servos are getting
torque.
"""

import termios
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Protocol

from lbr.drivers.line_lock import SURE, TakenError, alone, drop_output, share
from lbr.drivers.watch import DISMISSED, TURNING, outlasted

STEP_S = 0.05


class Releasing(Protocol):
    """The orders of a driver to its servos after its death. The line is its own while it writes and reads.

    An OSError, as a DeviceError is one, says that the line is gone. `blind`: it cannot ask who has torque, so that it
    acts only where the driver said that something may move. `least_hold_s`: it holds at least this long.
    """

    blind: bool
    least_hold_s: float

    def hold(self) -> bool:
        """Hold every servo that has torque; return whether there may be any."""

    def keep(self) -> None:
        """Go on holding; called at each step while they hold. It is to notice a line that is gone."""

    def prepare(self) -> float:
        """Make ready to fade; return the seconds that this takes."""

    def fade(self, strength: float) -> None:
        """Give them this share of the torque that they had; called at each step."""

    def off(self) -> None:
        """Take their torque."""


class GuardRelease:
    """Holds, fades and releases. `sleep` and `clock` are for tests."""

    def __init__(
        self,
        servos: Releasing,
        line: int,
        sleep: Callable[[float], None] = time.sleep,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._servos = servos
        self._line = line
        self._sleep = sleep
        self._clock = clock

    def act(self, hold_s: float, release_s: float) -> None:
        """Return when nothing has torque any more, or another driver took the line."""
        share(self._line)
        with suppress(TakenError, OSError, termios.error):
            with alone(self._line):
                held = self._servos.hold()
            if held:
                self._release(hold_s, release_s)

    def _release(self, hold_s: float, release_s: float) -> None:
        self._steps(hold_s, lambda _left: self._servos.keep())
        with alone(self._line):
            settling_s = self._servos.prepare()
        self._steps(settling_s, lambda _left: self._servos.keep())
        self._steps(release_s, self._servos.fade)
        for _ in range(SURE):
            with alone(self._line):
                self._servos.off()
            self._sleep(STEP_S)

    def _steps(self, seconds: float, act: Callable[[float], None]) -> None:
        """Act at each step, told the share of the time that is left, as long as no new driver has the line."""
        until = self._clock() + seconds
        while (left_s := until - self._clock()) > 0.0:
            with alone(self._line):
                act(left_s / seconds)
            self._sleep(min(STEP_S, left_s))


def run(words: Sequence[str], make: Callable[[int, list[int], Sequence[str]], Releasing]) -> None:
    """Run as the docstring of this module says. `make` gets the line, the servos' ids and the words of the driver's
    own."""
    line, pipe, driver, silence_ms, words_fd = (int(word) for word in words[:5])
    last = bytes.fromhex(words[5]) if words[5] != "-" else b""
    hold_s, release_s = float(words[6]), float(words[7])
    servos = make(line, [int(word) for word in words[8].split(",") if word], words[9:])
    said = outlasted(pipe, driver, silence_ms, words_fd, last)
    if said == TURNING or (said != DISMISSED and not servos.blind):
        GuardRelease(servos, line).act(max(hold_s, servos.least_hold_s), release_s)
        drop_output(line)
