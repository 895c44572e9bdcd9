"""A guard's short locks on a line: it locks only while it writes, and stops as soon as a new driver has the line."""

import fcntl
import termios
from collections.abc import Iterator
from contextlib import contextmanager, suppress

SURE = 3
"""The number of times that an unanswered last command is sent."""


class TakenError(Exception):
    """Another driver has the line."""


def share(tty: int) -> None:
    """Let a new driver open the line although the dead one had opened it exclusively."""
    with suppress(OSError, termios.error):
        fcntl.ioctl(tty, termios.TIOCNXCL)


@contextmanager
def alone(tty: int) -> Iterator[None]:
    """Hold the lock on the line, or raise TakenError."""
    try:
        fcntl.flock(tty, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise TakenError from None
    try:
        yield
    finally:
        fcntl.flock(tty, fcntl.LOCK_UN)


def drop_output(tty: int) -> None:
    """Discard the output that has not left: otherwise closing the line waits for it, for half a minute."""
    with suppress(OSError, termios.error):
        termios.tcflush(tty, termios.TCOFLUSH)
