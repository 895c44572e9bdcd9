"""The guard's program: after the driver's death the servos hold where they are, then their torque fades to off.

`python -m PROGRAM LINE_FD PIPE_FD DRIVER_PIDFD SILENCE_MS WORDS_FD WORDS_HEX HOLD_S RELEASE_S ID,ID… [MORE…]`, where
PROGRAM is a module of the driver that calls `run`. It locks the line only while it writes and reads, and ends as soon
as a new driver has the line. It imports little, as `run`'s caller should, because it starts while servos get torque.
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
    """A driver's last orders to its servos. The line is locked during each call.

    A lost line raises an OSError, such as a DeviceError. `blind`: it cannot read which servos have torque, so it acts
    only if the driver reported that something may move. `least_hold_s`: the shortest time of holding.
    """

    blind: bool
    least_hold_s: float

    def hold(self) -> bool:
        """Hold every servo that has torque; return whether any may have it."""

    def keep(self) -> None:
        """Continue to hold; called at each step of the hold. It must notice a lost line."""

    def prepare(self) -> float:
        """Prepare to fade; return the seconds that this takes."""

    def fade(self, strength: float) -> None:
        """Reduce their torque to this share of the original; called at each step."""

    def off(self) -> None:
        """Switch their torque off."""


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
        """Hold, fade and release; return earlier if another driver took the line."""
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
        """Call `act` with the remaining share of the time at each step, as long as no new driver has the line."""
        until = self._clock() + seconds
        while (left_s := until - self._clock()) > 0.0:
            with alone(self._line):
                act(left_s / seconds)
            self._sleep(min(STEP_S, left_s))


def run(words: Sequence[str], make: Callable[[int, list[int], Sequence[str]], Releasing]) -> None:
    """Run as the module's docstring describes; `make` gets the line, the servos' ids and the driver's own arguments."""
    line, pipe, driver, silence_ms, words_fd = (int(word) for word in words[:5])
    last = bytes.fromhex(words[5]) if words[5] != "-" else b""
    hold_s, release_s = float(words[6]), float(words[7])
    servos = make(line, [int(word) for word in words[8].split(",") if word], words[9:])
    last_beat = outlasted(pipe, driver, silence_ms, words_fd, last)
    if last_beat == TURNING or (last_beat != DISMISSED and not servos.blind):
        GuardRelease(servos, line).act(max(hold_s, servos.least_hold_s), release_s)
        drop_output(line)
