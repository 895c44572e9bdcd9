"""A second process that also holds a driver's line, and stops the device the moment the driver dies or hangs."""

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
"""The time that a guard may leave its messages unread: three times the silence that it allows its driver."""
STARTS_S = 20.0
"""The time that its program may take to start while nothing may move: an emulated processor needs seconds."""
DISMISS_S = 0.2
LAST_WORDS_S = 0.6
WOKEN = "its guard process was frozen for a moment, and goes on"
_LEFT: "list[subprocess.Popen[bytes]]" = []


class Guard:
    """Starts and feeds the guard process, which notices the death of the driver by a closed pipe, within about 1 ms.

    A driver that hangs or is frozen no longer beats; if something may move, the guard kills it after its silence limit.
    `command` returns the command line of the guard's program, given the descriptors of the pipe and of the driver's
    process. The kernel continues a frozen guard at the next beat and when the driver ends. `last_word_s` limits the
    time of its last command.
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
        self._unread_since: float | None = None
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
        """The guard's process id."""
        return self._process.pid

    @property
    def standing(self) -> bool:
        """Return whether it still watches: it is alive and reads the beats, or is starting while nothing may move."""
        if self._process.poll() is not None:
            return False
        if not self.listens and not self._turning:
            return self._beat_at - self._begun <= STARTS_S
        return self._unread_since is None or self._beat_at - self._unread_since <= DEAF_S

    @property
    def listens(self) -> bool:
        """Return whether its program runs and has read a beat; a driver's death before that is noticed late."""
        if not self._listens and self._process.poll() is None and not _unread(self._alive):
            self._listens, self._unread_since = True, None
        return self._listens

    def woken(self) -> bool:
        """Return whether it was frozen and has been continued since the last call."""
        with suppress(ChildProcessError):
            return os.waitid(os.P_PID, self._process.pid, os.WCONTINUED | os.WNOHANG) is not None
        return False

    def beat(self, *, turning: bool) -> None:
        """Send a beat, with whether something may move; rate-limited, so call it freely."""
        now = self._clock()
        if turning == self._turning and now - self._beat_at < (BEAT_S if turning else RESTING_BEAT_S):
            return
        self._turning, self._beat_at = turning, now
        self._unread_since = None if not _unread(self._alive) else self._unread_since or now
        with suppress(OSError):  # dead or not reading: `standing` reports it
            os.write(self._alive, b"m" if turning else b"z")

    def dismiss(self) -> None:
        """Dismiss it without a stop; it closes the line."""
        with suppress(OSError):
            os.write(self._alive, b"q")
        self._part(DISMISS_S)

    def speak(self) -> None:
        """Have it stop the device now, as after a driver's death, and close the line."""
        self._part(LAST_WORDS_S)

    def leave(self) -> None:
        """Leave the line to it, as after a driver's death, without waiting."""
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
    """Start the guard in a process group of its own, but in the driver's session, where it shares the driver's
    priority."""
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
