"""Lifelines: pipes by whose end the kernel tells a process that what it works for is gone, frozen or not.

`MARK` and `LAST_WORD` are variables in the environment of what the executive starts, by which its reaper knows it.
"""

import fcntl
import os
import signal

MARK = "LBR_RUN"
"""Which run a process belongs to, and which of its processes it comes from."""
LAST_WORD = "LBR_LAST_WORD_S"
"""The seconds that a guard may take for its last word, once its driver is gone; without a guard, 0."""


def wake(pipe: int, pid: int) -> None:
    """Have the kernel continue process `pid`, should it be frozen, whenever its pipe gets something or hangs up."""
    fcntl.fcntl(pipe, fcntl.F_SETOWN, pid)
    fcntl.fcntl(pipe, fcntl.F_SETSIG, signal.SIGCONT)
    fcntl.fcntl(pipe, fcntl.F_SETFL, fcntl.fcntl(pipe, fcntl.F_GETFL) | os.O_ASYNC)
