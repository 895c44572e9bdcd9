"""The ranks on a busy machine: movers of the robot first, its mere users last.

Where the kernel groups by session (autogroup), a session is a scheduling group of its own, and niceness counts only
within a group. So the parent, which still has the right to, sets both. A rank that is not permitted stays as it is:
/proc shows the granted one.
"""

import contextlib
import errno
import os
from pathlib import Path

from lbr.executive.planning.process_specs import ProcessSpec

MOTION = -10
USUAL = 0
BACKGROUND = 10
"""At 15, a full machine runs the recorder so rarely that it answers only after seconds."""


def niceness(unit: ProcessSpec) -> int:
    """Return the niceness for a capability.

    Movers come first, with servers, as stops come through them, and with drivers and emulated devices, as real devices
    answer however busy the machine is.
    """
    if unit.moves or unit.serves or unit.family in {"driver", "simulation"}:
        return MOTION
    return BACKGROUND if unit.family in {"app", "program"} else USUAL


class Rank:
    """The niceness of a process and of its session, if it leads one.

    The session's file is opened at once: it becomes inaccessible when the process makes its memory private.
    """

    def __init__(self, pid: int) -> None:
        self._pid = pid
        self._session = -1
        self._due: int | None = None
        with contextlib.suppress(OSError):
            if os.getsid(pid) == pid:
                self._session = os.open(f"/proc/{pid}/autogroup", os.O_WRONLY | os.O_CLOEXEC)

    def set(self, nice: int) -> None:
        """Set a niceness; `retry` repeats what the kernel does not grant at once."""
        with contextlib.suppress(OSError):
            for task in Path(f"/proc/{self._pid}/task").iterdir():
                with contextlib.suppress(OSError):  # a thread that has ended
                    os.setpriority(os.PRIO_PROCESS, int(task.name), nice)
        self._due = nice if self._session >= 0 else None
        self.retry()

    def retry(self) -> None:
        """Repeat a refused request: the kernel accepts ten changes a second from a user other than root."""
        if self._due is None:
            return
        try:
            os.write(self._session, str(self._due).encode())
        except OSError as err:
            if err.errno == errno.EAGAIN:
                return
        self._due = None

    def close(self) -> None:
        """Close the session's file."""
        if self._session >= 0:
            os.close(self._session)
            self._session, self._due = -1, None


def rank(pid: int, nice: int) -> None:
    """Set the niceness of a process once."""
    found = Rank(pid)
    found.set(nice)
    found.close()
