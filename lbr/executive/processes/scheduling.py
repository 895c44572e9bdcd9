"""The ranks on a busy machine: movers of the robot first, mere users of it last.

A process in a session of its own is a scheduling group of its own where the kernel groups by session (autogroup), and
niceness alone counts only within a group; so both are set, by the parent, which still has the right to. A rank that is
not permitted is left as it is: /proc shows what was granted.
"""

import contextlib
import errno
import os
from pathlib import Path

from lbr.executive.planning.process_specs import ProcessSpec

MOTION = -10
USUAL = 0
BACKGROUND = 10
"""At 15 a machine that is quite full gives so little that what is asked of the black box is not answered within
seconds."""


def niceness(unit: ProcessSpec) -> int:
    """Return the niceness that a capability should have.

    Emulated devices rank with the drivers: real ones answer however busy the machine is. Stops come by what serves.
    """
    if unit.moves or unit.serves or unit.family in {"driver", "simulation"}:
        return MOTION
    return BACKGROUND if unit.family in {"app", "program"} else USUAL


class Rank:
    """The niceness of a process and of its session, if it leads one.

    The session's file is opened at once, because a process that keeps its memory private takes it away from us.
    """

    def __init__(self, pid: int) -> None:
        self._pid = pid
        self._session = -1
        self._due: int | None = None
        with contextlib.suppress(OSError):
            if os.getsid(pid) == pid:
                self._session = os.open(f"/proc/{pid}/autogroup", os.O_WRONLY | os.O_CLOEXEC)

    def set(self, nice: int) -> None:
        """Ask for a niceness; what the kernel does not grant at once `retry` asks for again."""
        with contextlib.suppress(OSError):
            for task in Path(f"/proc/{self._pid}/task").iterdir():
                with contextlib.suppress(OSError):  # a thread that has ended
                    os.setpriority(os.PRIO_PROCESS, int(task.name), nice)
        self._due = nice if self._session >= 0 else None
        self.retry()

    def retry(self) -> None:
        """Ask again if need be: the kernel takes ten changes a second from a user that is not root."""
        if self._due is None:
            return
        try:
            os.write(self._session, str(self._due).encode())
        except OSError as err:
            if err.errno == errno.EAGAIN:
                return
        self._due = None

    def close(self) -> None:
        """Close what refers to the process."""
        if self._session >= 0:
            os.close(self._session)
            self._session, self._due = -1, None


def rank(pid: int, nice: int) -> None:
    """Give a process a niceness, once and for all."""
    found = Rank(pid)
    found.set(nice)
    found.close()
