"""The shutdown of a robot: it ends this process for certain, even if the main thread hangs.

Python runs signal handlers only in the main thread, between two instructions, and a call into a library may never
return. The low-level handler writes to a pipe at once, and a thread of this module reads that.
"""

import contextlib
import os
import signal
import sys
import threading
import time
from collections.abc import Callable

SIGNALS = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
HEARD_WITHIN_S = 2.5
"""The main loop goes round five times a second, even under load; if it has not begun to close by then, it hangs."""
OVER_WITHIN_S = 5.0
"""The processes have 2.5 s to end, then the external commands, the last rows and the routers."""
LEFT_WITHIN_S = 3.0
"""The rest then takes milliseconds, and a second on a very busy machine."""
FORCED = 70


class Shutdown:
    """Ends the process some seconds after `begin`, or after one of `signals`, which call `wake` at once.

    `why` is the first reason to end, and `code` the exit code of an end in order.
    """

    def __init__(
        self,
        wake: Callable[[], None],
        *,
        signals: tuple[int, ...] = (),
        end: Callable[[str], None] | None = None,
        heard_s: float = HEARD_WITHIN_S,
        over_s: float = OVER_WITHIN_S,
    ) -> None:
        self.why = ""
        self.code = 0
        self._wake = wake
        self._signals = frozenset(signals)
        self._end = end or _end
        self._heard_s, self._over_s = heard_s, over_s
        self._begun = threading.Event()
        self._heard = threading.Event()
        self._read, self.signal_fd = os.pipe()
        os.set_blocking(self.signal_fd, False)
        threading.Thread(target=self._listen, name="signals", daemon=True).start()
        threading.Thread(target=self._count, name="last resort", daemon=True).start()

    def heed_signals(self) -> None:
        """Begin at a signal, including one that a file has noted before; from the main thread."""
        file, noted = signal.set_wakeup_fd(self.signal_fd, warn_on_full_buffer=False), b""
        for number in self._signals:
            signal.signal(number, lambda n, _frame: self.begin(f"signal {signal.Signals(n).name}"))
        if file >= 0:
            noted = os.pread(file, os.fstat(file).st_size, 0)
            os.close(file)
        if signal.SIGINT in noted:
            raise KeyboardInterrupt

    def begin(self, why: str, code: int = 0) -> None:
        """Begin the countdown; may be called from any thread."""
        self.why, self.code = self.why or why, self.code or code
        self._begun.set()
        self._wake()

    def closing(self) -> None:
        """Note that the main thread is closing."""
        self._heard.set()

    def _listen(self) -> None:
        while got := os.read(self._read, 4096):
            if self._signals & set(got):
                self._begun.set()
            self._wake()

    def _count(self) -> None:
        self._begun.wait()
        since = time.monotonic()
        if not self._heard.wait(self._heard_s):
            self._end(f"the main thread has not noticed the shutdown for {self._heard_s:g} s")
        else:
            time.sleep(max(0.0, since + self._over_s - time.monotonic()))  # the end of the process ends this thread
            self._end(f"the shutdown takes longer than {self._over_s:g} s")


def leave_for_certain() -> None:
    """Ignore further signals, of which Python would die at its end, and let the kernel bound the time."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, LEFT_WITHIN_S)


def _end(why: str) -> None:
    """Leave at once; the processes notice by their lifelines, stop their motion and end."""
    with contextlib.suppress(OSError):
        os.write(sys.stderr.fileno(), f"executive: {why}; ended by force\n".encode())
    os._exit(FORCED)
