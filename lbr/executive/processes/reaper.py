"""The executive's side of its reaper: a small process that outlives it and ends its remains."""

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
"""The time for the reaper to finish, a few times what it needs on a busy machine."""
LEAVE_S = 0.1
BEAT_S = 1.0
HANGS_S = 10.0
"""The main loop takes at most a second for a round. The longest at a start was 0.6 s, on two cores at load 15."""
MOST_REMEMBERED = 64
"""The number of ended drivers that a new reaper learns of: their guards may still send."""
END, BEAT, REST = ".", "!", "_"
_LEFT: "list[subprocess.Popen[bytes]]" = []


class Mark:
    """The reaper's mark of a process and its descendants; `environment` goes into theirs.

    Guards can exist only in the session of a process with `guards`.
    """

    def __init__(self, reaper: "Reaper", number: int) -> None:
        self._reaper = reaper
        self._number = number
        self._began = "+"
        self.environment = {
            lifeline.MARK: f"{reaper.token}.{number:09d}"
        }  # all have one length: a forked process writes its own over it

    def began(self, pid: int) -> None:
        """Report which process it is; it leads a session."""
        said = self._reaper.known[self._number] = f"{self._began}{self._number} {pid}"
        self._reaper.say(said)

    def guards(self, pid: int) -> None:
        """Report that it may leave a guard behind from now on."""
        if self._began != "*":
            self._began = "*"
            self.began(pid)

    def ended(self, *, spared: bool = False) -> None:
        """Report its end: its remains are ended now, or, if `spared`, at the end of the run."""
        if (began := self._reaper.known.pop(self._number, None)) is not None:
            if self._began == "*":
                self._reaper.left.append(f"={began.split()[1]}")
            self._reaper.say(f"{'~' if spared else '-'}{self._number}")


class Reaper:
    """The reaper, which is replaced when it dies. Each word continues it if it is frozen.

    Any thread may call `say`. From the first `beat` until `rest`, the reaper ends this process if `beat` is not called
    for `hangs_s`.
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
        """Report that the main loop runs; cheap enough for every turn, and to be called from nowhere else."""
        now = time.monotonic()
        if now - self._beat_at >= BEAT_S:
            self._beat_at = now
            self.say(BEAT)

    def rest(self) -> None:
        """Announce that the main loop will not beat until the next call of `beat`."""
        self._beat_at = 0.0
        self.say(REST)

    def step(self) -> str:
        """Replace it if need be; return why that fails, or an empty text."""
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
        """Send it a word; if its pipe is full, it is replaced at the next step, and gets all words again."""
        with self._lock:
            try:
                os.write(self._pipe, f"{word}\n".encode())
            except BlockingIOError:
                self._popen.kill()
            except OSError:  # it is dead: the next step notices
                pass

    def close(self) -> None:
        """Let it end the remains, as if this process had died, but without waiting for guards that still send."""
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
        except BaseException:  # an interruption, too, must leave nothing open; it is raised again
            os.close(ours)
            raise
        finally:
            os.close(theirs)
        self._pipe = ours
        scheduling.rank(self._popen.pid, scheduling.MOTION)
