"""The exit of a process: within a bound that the kernel keeps, and with the reason reported."""

import re
import signal
import sys
import traceback
from contextlib import suppress
from pathlib import Path

CRASHED = 70
RUNTIME = re.compile(r"/lbr/(?:capability/|plugins\.py\Z)|^<frozen |/importlib/__init__\.py\Z")
"""Files whose lines say nothing of what went wrong in another's."""
CLOSE_LIMIT_S = 0.5


def within(seconds: float) -> None:
    """Let the kernel end this process then, whatever hangs in it, and whichever thread holds the interpreter."""
    signal.setitimer(signal.ITIMER_REAL, seconds)


def text(err: BaseException) -> str:
    """Say what was raised, and in which line of whose file: the last that is not the runtime's own."""
    with suppress(Exception):  # that cannot even be told
        frames = traceback.extract_tb(err.__traceback__)
        last = next((frame for frame in reversed(frames) if not RUNTIME.search(frame.filename)), None)
        where = f" ({Path(last.filename).name}, line {last.lineno})" if last else ""
        return f"{type(err).__name__}: {err}{where}"
    return type(err).__name__


def trace(err: BaseException) -> None:
    """Write down where it was raised."""
    traceback.print_exception(err)
    sys.stderr.flush()
