"""A second process that holds the motor line too, and writes zero the moment the driver dies."""

import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

from lbr.drivers.roboteq.protocol import STOP

DISMISS_S = 0.2
LAST_WORDS_S = 0.5
PROGRAM = Path(__file__).with_name("zero_on_death.py")


class Guard:
    """Kills of every kind close the driver's end of a pipe; the guard sees that within a millisecond or so.

    It cannot see a driver that hangs or is frozen: that is the controller's watchdog's part.
    """

    def __init__(self, tty: int) -> None:
        watched, self._alive = os.pipe()
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-I", "-S", str(PROGRAM), str(tty), str(watched), STOP.hex()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pass_fds=(tty, watched),
                start_new_session=True,
            )
        except OSError:
            os.close(self._alive)
            raise
        finally:
            os.close(watched)

    @property
    def pid(self) -> int:
        """Its process id."""
        return self._process.pid

    @property
    def standing(self) -> bool:
        """Whether it still watches."""
        return self._process.poll() is None

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
