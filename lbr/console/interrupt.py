"""The reaction of a process to signals that end it."""

import contextlib
import signal
import threading
from collections.abc import Callable


def told_to_leave(leave: Callable[[], None], *also: signal.Signals) -> contextlib.ExitStack:
    """Return a context in which SIGHUP, SIGTERM and `also` call `leave`, unless they are ignored.

    Outside the main thread it does nothing.
    """
    stack = contextlib.ExitStack()
    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGHUP, signal.SIGTERM, *also):
            if signal.getsignal(number) != signal.SIG_IGN:
                stack.callback(signal.signal, number, signal.signal(number, lambda _number, _frame: leave()))
    return stack
