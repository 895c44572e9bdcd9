"""Ways for a process to be told to leave: they end it as Ctrl-C does, so that what it moves is stopped."""

import contextlib
import signal
import threading
from collections.abc import Callable
from typing import Any


def _interrupt(_number: int, _frame: object) -> None:
    raise KeyboardInterrupt


def interruptible(handle: Callable[[int, Any], None] = _interrupt) -> contextlib.ExitStack:
    """Return a context in which SIGHUP and SIGTERM are handled; outside the main thread it does nothing."""
    stack = contextlib.ExitStack()
    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGHUP, signal.SIGTERM):
            stack.callback(signal.signal, number, signal.signal(number, handle))
    return stack
