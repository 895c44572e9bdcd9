"""The executive's side of its reaper: a small process that outlives it, to end whatever else does."""

import itertools
import os
import secrets
import select
import subprocess
import sys
import threading
import time
from collections import deque
from pathlib import Path

from lbr.capability import lifeline
from lbr.errors import LbrError
from lbr.executive.processes import scheduling

PROGRAM = Path(__file__).with_name("reap.py")
END_S = 1.0
"""The patience with its work, a few times its time on a busy machine."""
LEAVE_S = 0.1
BEAT_S = 1.0
HANGS_S = 10.0
"""The main loop goes round at least once a second; the longest that it took at a
start, on two cores at load 15, were 0.6 s."""
MOST_REMEMBERED = 64
"""The number of ended drivers that a new reaper learns of: their guards may still speak."""
END, BEAT, REST = ".", "!", "_"
_LEFT: "list[subprocess.Popen[bytes]]" = []


class Mark:
    """The reaper's mark of a process and of all that it starts; `environment` goes into its own.

    Only a process in the session of one that `guards` may be a guard.
    """

    def __init__(self, reaper: "Reaper", number: int) -> None:
        self._reaper = reaper
        self._number = number
        self._began = "+"
        self.environment = {
            lifeline.MARK: f"{reaper.token}.{number:09d}"
        }  # of one length: a forked process wears its own

    def began(self, pid: int) -> None:
        """Say which process it is; it leads a session."""
        said = self._reaper.known[self._number] = f"{self._began}{self._number} {pid}"
        self._reaper.say(said)

    def guards(self, pid: int) -> None:
        """Say that it may leave a guard behind from now on."""
        if self._began != "*":
            self._began = "*"
            self.began(pid)

    def ended(self, *, spared: bool = False) -> None:
        """Say that it is no more: what it has left behind is ended now, or `spared` until the run ends."""
        if (began := self._reaper.known.pop(self._number, None)) is not None:
            if self._began == "*":
                self._reaper.left.append(f"={began.split()[1]}")
            self._reaper.say(f"{'~' if spared else '-'}{self._number}")


class Reaper:
    """Replaced when it dies; what is said to it continues it, if it is frozen. `say` may come from any thread.

    From the first `beat` until `rest` it ends this process, should that not `beat` for `hangs_s`.
    """

    def __init__(self, hangs_s: float = HANGS_S) -> None:
        self._hangs_s = hangs_s
        self.token = secrets.token_hex(8)
        self.known: dict[int, str] = {}
        self.left: deque[str] = deque(maxlen=MOST_REMEMBERED)
        self._beat_at = 0.0
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

    def beat(self) -> None:
        """Say that the main loop goes round; cheap to call at every turn, and to be called from nowhere else."""
        now = time.monotonic()
        if now - self._beat_at >= BEAT_S:
            self._beat_at = now
            self.say(BEAT)

    def rest(self) -> None:
        """Expect no beats of the main loop until the next one."""
        self._beat_at = 0.0
        self.say(REST)

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
        for word in (*list(self.left), *list(self.known.values())):
            self.say(word)
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

    def _words(self) -> tuple[str, str, str, str]:
        return f"{lifeline.MARK}={self.token}.", f"{lifeline.LAST_WORD}=", str(os.getpid()), repr(self._hangs_s)

    def _hang_up(self) -> None:
        if self._pipe >= 0:
            os.close(self._pipe)
        self._pipe = -1

    def _start(self) -> None:
        theirs, ours = os.pipe()
        try:
            os.set_blocking(ours, False)
            self._popen = subprocess.Popen(
                [sys.executable, "-I", "-S", str(PROGRAM), *self._words()],
                stdin=theirs,
                stdout=subprocess.DEVNULL,
                cwd="/",
                start_new_session=True,
            )
            lifeline.wake(theirs, self._popen.pid)
        except BaseException:  # also an interruption leaves nothing open; it goes on upwards
            os.close(ours)
            raise
        finally:
            os.close(theirs)
        self._pipe = ours
        scheduling.rank(self._popen.pid, scheduling.MOTION)
