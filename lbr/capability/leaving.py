"""The exit of a process: within a bound that the kernel enforces, and with its reason reported."""

import re
import signal
import sys
import traceback
from contextlib import suppress
from pathlib import Path

CRASHED = 70
RUNTIME = re.compile(r"/lbr/(?:capability/|plugins\.py\Z)|^<frozen |/lib\d*/python3\.\d+t?/(?!(?:site|dist)-packages/)")
"""Files whose lines do not explain a fault in somebody else's file."""
CLOSE_LIMIT_S = 0.5


def within(seconds: float) -> None:
    """Let the kernel end this process after that time, whatever hangs, and whichever thread holds the interpreter."""
    signal.setitimer(signal.ITIMER_REAL, seconds)


def text(err: BaseException) -> str:
    """Return an exception as text, with its file and line: the last one outside runtime and standard library."""
    with suppress(Exception):  # not even its text can be had
        frames = traceback.extract_tb(err.__traceback__)
        last = next((frame for frame in reversed(frames) if not RUNTIME.search(frame.filename)), None)
        where = f" ({Path(last.filename).name}, line {last.lineno})" if last else ""
        return f"{type(err).__name__}: {err}{where}"
    return type(err).__name__


def trace(err: BaseException) -> None:
    """Log where it was raised."""
    traceback.print_exception(err)
    sys.stderr.flush()
