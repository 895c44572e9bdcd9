"""A guard has a line alone only while it speaks: the moment a new driver has it, the guard is done."""

import fcntl
import termios
from collections.abc import Iterator
from contextlib import contextmanager, suppress

SURE = 3
"""The number of times that an unanswered last command is sent."""


class TakenError(Exception):
    """Another driver has the line."""


def share(tty: int) -> None:
    """Let a new driver open the line although the dead one had it for itself."""
    with suppress(OSError, termios.error):
        fcntl.ioctl(tty, termios.TIOCNXCL)


@contextmanager
def alone(tty: int) -> Iterator[None]:
    """Have the line alone, or raise TakenError."""
    try:
        fcntl.flock(tty, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise TakenError from None
    try:
        yield
    finally:
        fcntl.flock(tty, fcntl.LOCK_UN)


def drop_output(tty: int) -> None:
    """Throw away what has not left: closing a line waits for its output, for half a minute."""
    with suppress(OSError, termios.error):
        termios.tcflush(tty, termios.TCOFLUSH)
