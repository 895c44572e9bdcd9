"""Lifelines: pipes that close when their owner is gone, which the kernel reports even to a frozen process.

`MARK` and `LAST_WORD` are variables in the environment of every process that the executive starts, by which its reaper
identifies it.
"""

import fcntl
import os
import signal

MARK = "LBR_RUN"
"""The run to which a process belongs, and the process of it that is its ancestor."""
LAST_WORD = "LBR_LAST_WORD_S"
"""The seconds that a guard has for its last command, once its driver is gone; without a guard, 0."""


def wake(pipe: int, pid: int) -> None:
    """Have the kernel continue process `pid` if it is frozen, whenever its pipe receives something or closes."""
    fcntl.fcntl(pipe, fcntl.F_SETOWN, pid)
    fcntl.fcntl(pipe, fcntl.F_SETSIG, signal.SIGCONT)
    fcntl.fcntl(pipe, fcntl.F_SETFL, fcntl.fcntl(pipe, fcntl.F_GETFL) | os.O_ASYNC)
