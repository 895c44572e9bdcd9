"""A second process that holds a driver's line too, and has the last word on it the moment the driver dies or hangs."""

import os
import subprocess
import sys
import termios
from collections.abc import Callable, Collection
from contextlib import suppress
from fcntl import ioctl
from math import ceil

from lbr.capability import lifeline

BEAT_S = 0.015
RESTING_BEAT_S = 0.5
DEAF_S = 0.4
"""The time that a guard may leave its messages unread: three times the silence that it grants its driver."""
STARTS_S = 20.0
"""The time that its program may take to start, as long as nothing may move: an emulated processor needs seconds for it.
"""
DISMISS_S = 0.2
LAST_WORDS_S = 0.6
WOKEN = "its guard process was frozen for a moment, and goes on"
_LEFT: "list[subprocess.Popen[bytes]]" = []


class Guard:
    """Kills of every kind close the driver's end of a pipe; the guard sees that within a millisecond or so.

    A driver that hangs or is frozen no longer beats: if something may move, the guard kills it after its time of
    silence. `command` makes the command line of its program from the descriptors of the pipe and of the driver's
    process. A guard that is frozen goes on with the next beat, and when the driver ends, because the kernel continues
    it. It may take `last_word_s` for its last word.
    """

    def __init__(
        self,
        command: Callable[[int, int], list[str]],
        fds: Collection[int],
        clock: Callable[[], float],
        last_word_s: float,
    ) -> None:
        self._clock = clock
        self._begun = self._beat_at = clock()
        self._turning = False
        self._unheard: float | None = None
        self._listens = False
        watched, self._alive = os.pipe()
        driver = -1
        try:
            os.set_blocking(self._alive, False)
            driver = os.pidfd_open(os.getpid())
            self._process = _start(command(watched, driver), (watched, driver, *fds), last_word_s)
            lifeline.wake(watched, self._process.pid)
            os.write(self._alive, b"z")
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
        """Return whether it still watches: it lives, and hears the beats, or is starting while nothing may move."""
        if self._process.poll() is not None:
            return False
        if not self.listens and not self._turning:
            return self._beat_at - self._begun <= STARTS_S
        return self._unheard is None or self._beat_at - self._unheard <= DEAF_S

    @property
    def listens(self) -> bool:
        """Return whether its program runs and has heard its driver: before, a death of the driver is only noticed
        later."""
        if not self._listens and self._process.poll() is None and not _unread(self._alive):
            self._listens, self._unheard = True, None
        return self._listens

    def woken(self) -> bool:
        """Return whether it was frozen, and goes on, since the last call."""
        with suppress(ChildProcessError):
            return os.waitid(os.P_PID, self._process.pid, os.WCONTINUED | os.WNOHANG) is not None
        return False

    def beat(self, *, turning: bool) -> None:
        """Say that the driver's loop goes round, and whether something may move; rate-limited, so call it freely."""
        now = self._clock()
        if turning == self._turning and now - self._beat_at < (BEAT_S if turning else RESTING_BEAT_S):
            return
        self._turning, self._beat_at = turning, now
        self._unheard = None if not _unread(self._alive) else self._unheard or now
        with suppress(OSError):  # dead or deaf: `standing` tells
            os.write(self._alive, b"m" if turning else b"z")

    def dismiss(self) -> None:
        """Dismiss it without a stop of its own; it closes the line."""
        with suppress(OSError):
            os.write(self._alive, b"q")
        self._part(DISMISS_S)

    def speak(self) -> None:
        """Have it stop the device now, as if the driver had died; then it closes the line."""
        self._part(LAST_WORDS_S)

    def leave(self) -> None:
        """Leave the line to it, as if the driver had died, and do not wait for it."""
        os.close(self._alive)
        _LEFT[:] = [process for process in _LEFT if process.poll() is None]
        _LEFT.append(self._process)

    def _part(self, within_s: float) -> None:
        os.close(self._alive)
        try:
            self._process.wait(within_s)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def _start(command: list[str], fds: Collection[int], last_word_s: float) -> "subprocess.Popen[bytes]":
    """Start it in a process group of its own, but in the driver's session: there it shares the driver's priority."""
    return subprocess.Popen(
        [sys.executable, *command],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        pass_fds=[fd for fd in fds if fd >= 0],
        env=os.environ | {lifeline.LAST_WORD: str(ceil(last_word_s))},
        process_group=0,
    )


def _unread(pipe: int) -> int:
    return int.from_bytes(ioctl(pipe, termios.FIONREAD, b"\0\0\0\0"), sys.byteorder)
