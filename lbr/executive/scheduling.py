"""Who outranks whom on a busy machine: what moves the robot first, what merely uses it last.

A process in a session of its own is a scheduling group of its own where the kernel groups by session (autogroup), and
niceness alone counts only within a group; so both are set. The parent sets them, before a child has any thread. What is
not permitted is left as it is: /proc shows what was granted.
"""

import errno
import os
from pathlib import Path

from lbr.executive.plan import Unit

MOTION = -10
USUAL = 0
BACKGROUND = 10


def niceness(unit: Unit) -> int:
    """Return the niceness that a capability should have; emulated hardware ranks as the machine's own does."""
    if unit.moves or unit.family == "driver" or unit.config.lan is not None:  # stops come through that door, too
        return MOTION
    return BACKGROUND if unit.family in {"app", "program"} else USUAL


def rank(pid: int, nice: int) -> bool:
    """Give a process, and its session if it leads one, a niceness; return False if it should be tried again soon.

    The kernel takes ten such changes of a session a second from whoever is not root.
    """
    try:
        os.setpriority(os.PRIO_PROCESS, pid, nice)
        if os.getsid(pid) == pid:
            Path(f"/proc/{pid}/autogroup").write_text(str(nice))
    except OSError as err:
        return err.errno != errno.EAGAIN
    return True
