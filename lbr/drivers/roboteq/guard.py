"""A second process that holds the motor line too, and writes zero the moment the driver dies or hangs."""

import os
import subprocess
import sys
import termios
from collections.abc import Callable
from contextlib import suppress
from fcntl import ioctl
from pathlib import Path

from lbr.capability.reporter import last_words
from lbr.drivers.roboteq.protocol import STOP

BEAT_S = 0.015
RESTING_BEAT_S = 0.5
DEAF_S = 1.0
DISMISS_S = 0.2
LAST_WORDS_S = 0.6
PROGRAM = Path(__file__).with_name("zero_on_death.py")


class Guard:
    """Kills of every kind close the driver's end of a pipe; the guard sees that within a millisecond or so.

    A driver that hangs or is frozen no longer beats: if a motor may turn, the guard kills it after `silence_ms`.
    """

    def __init__(self, tty: int, silence_ms: int, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._beat_at = clock()
        self._turning = False
        self._unheard: float | None = None
        watched, self._alive = os.pipe()
        driver = -1
        try:
            os.set_blocking(self._alive, False)
            driver = os.pidfd_open(os.getpid())
            self._process = _start(tty, watched, driver, silence_ms)
        except OSError:
            os.close(self._alive)
            raise
        finally:
            os.close(watched)
            if driver >= 0:
                os.close(driver)

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    @property
    def standing(self) -> bool:
        """Whether it still watches: it lives, and hears the beats."""
        deaf = self._unheard is not None and self._beat_at - self._unheard > DEAF_S
        return not deaf and self._process.poll() is None

    def beat(self, *, turning: bool) -> None:
        """Say that the driver's loop goes round, and whether a motor may turn; rate-limited, so call it freely."""
        now = self._clock()
        if turning == self._turning and now - self._beat_at < (BEAT_S if turning else RESTING_BEAT_S):
            return
        self._turning, self._beat_at = turning, now
        self._unheard = None if not _unread(self._alive) else self._unheard or now
        with suppress(OSError):  # dead or deaf: `standing` tells
            os.write(self._alive, b"m" if turning else b"z")

    def dismiss(self) -> None:
        """Send it away without a last word; it lets go of the line."""
        with suppress(OSError):
            os.write(self._alive, b"q")
        self._part(DISMISS_S)

    def speak(self) -> None:
        """Have it write zero now, as if the driver had died; then it lets go of the line."""
        self._part(LAST_WORDS_S)

    def _part(self, within_s: float) -> None:
        os.close(self._alive)
        try:
            self._process.wait(within_s)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def _start(tty: int, watched: int, driver: int, silence_ms: int) -> "subprocess.Popen[bytes]":
    """Start it in a process group of its own, but in the driver's session: there it shares the driver's priority."""
    fd, words = last_words("hung", f"the motor driver stood still for {silence_ms} ms while a motor could turn")
    numbers = [str(number) for number in (tty, watched, driver, silence_ms)]
    return subprocess.Popen(
        [sys.executable, "-I", "-S", str(PROGRAM), *numbers, STOP.hex(), *([str(fd), words.hex()] if fd >= 0 else [])],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        pass_fds=(tty, watched, driver, *([fd] if fd >= 0 else [])),
        process_group=0,
    )


def _unread(pipe: int) -> int:
    return int.from_bytes(ioctl(pipe, termios.FIONREAD, b"\0\0\0\0"), sys.byteorder)
