"""The executive's side of its reaper: a small process that outlives it, to end whatever else does."""

import itertools
import os
import secrets
import select
import subprocess
import sys
import threading
from pathlib import Path

from lbr.capability import lifeline
from lbr.errors import LbrError
from lbr.executive.processes import scheduling

PROGRAM = Path(__file__).with_name("reap.py")
END_S = 1.0
"""So long its work is waited for, a few times what it takes on a busy machine."""
LEAVE_S = 0.1
END = "."
_LEFT: "list[subprocess.Popen[bytes]]" = []


class Mark:
    """What one process is known by to the reaper, with all that it starts; `environment` goes into its own."""

    def __init__(self, reaper: "Reaper", number: int) -> None:
        self._reaper = reaper
        self._number = number
        self.environment = {lifeline.MARK: f"{reaper.token}.{number}"}

    def began(self, pid: int) -> None:
        """Say which process it is; it leads a session."""
        self._reaper.known[self._number] = pid
        self._reaper.say(f"+{self._number} {pid}")

    def ended(self, *, kept: bool = False) -> None:
        """Say that it is no more: what it has left behind is ended now, or `kept` until the run ends."""
        if self._reaper.known.pop(self._number, None) is not None:
            self._reaper.say(f"{'~' if kept else '-'}{self._number}")


class Reaper:
    """Replaced when it dies; what is said to it continues it, if it is frozen. `say` may come from any thread."""

    def __init__(self) -> None:
        self.token = secrets.token_hex(8)
        self.known: dict[int, int] = {}
        self._numbers = itertools.count()
        self._lock = threading.Lock()
        self._pipe = -1
        try:
            self._start()
        except OSError as err:
            raise LbrError(f"the process that ends what is left over does not start: {err}; free some memory") from err

    def mark(self) -> Mark:
        """Return a new mark, for a process that is about to start."""
        return Mark(self, next(self._numbers))

    def step(self) -> str:
        """Replace it if need be; return why that cannot be, or nothing."""
        if self._popen.poll() is None:
            return ""
        try:
            with self._lock:
                self._hang_up()
                self._start()
        except OSError as err:
            return str(err)
        for number, pid in list(self.known.items()):
            self.say(f"+{number} {pid}")
        return ""

    def say(self, word: str) -> None:
        """Tell it; one that takes nothing is replaced at the next step, and told all again."""
        with self._lock:
            try:
                os.write(self._pipe, f"{word}\n".encode())
            except BlockingIOError:
                self._popen.kill()
            except OSError:  # it is dead: the next step sees that
                pass

    def close(self) -> None:
        """Have it end what is left, as if this process had died; only guards that still speak are not waited for."""
        self.say(END)
        with self._lock:
            if self._pipe >= 0:
                poll = select.poll()
                poll.register(self._pipe, 0)
                poll.poll(END_S * 1000.0)  # until it has closed its end
            self._hang_up()
        try:
            self._popen.wait(LEAVE_S)
        except subprocess.TimeoutExpired:
            _LEFT.append(self._popen)

    def _hang_up(self) -> None:
        if self._pipe >= 0:
            os.close(self._pipe)
        self._pipe = -1

    def _start(self) -> None:
        theirs, ours = os.pipe()
        try:
            os.set_blocking(ours, False)
            self._popen = subprocess.Popen(
                [sys.executable, "-I", "-S", str(PROGRAM), f"{lifeline.MARK}={self.token}.", f"{lifeline.LAST_WORD}="],
                stdin=theirs,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                cwd="/",
                start_new_session=True,
            )
            lifeline.wake(theirs, self._popen.pid)
        except BaseException:
            os.close(ours)
            raise
        finally:
            os.close(theirs)
        self._pipe = ours
        scheduling.rank(self._popen.pid, scheduling.MOTION)
