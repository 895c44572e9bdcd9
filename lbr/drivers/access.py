"""The advice for a device that this user may not open: join its group, or wait until udev has set it."""

import errno
import time
from pathlib import Path

from lbr.messages.codes import Code

SETTLED_S = 5.0
"""udev sets group and mode within a second of a plug-in; a busy Pi at its start takes several."""


def refused(path: str, group: str = "") -> str:
    """Return the end of a sentence about a device that this user may not open; udev may still be setting its rights."""
    join = f"join the group {group or 'of that file'} and log in again"
    if is_settling(path):
        soon = "it was plugged in just now, and udev may still be setting its group"
        return f"may not be opened by this user yet: {soon}; if this stays, {join}"
    return f"may not be opened by this user; {join}"


def code_of(err: BaseException) -> Code:
    """Return the code for a device that cannot be opened: no rights, busy, or not reachable."""
    match getattr(err, "errno", None):
        case errno.EACCES | errno.EPERM:
            return "rights"
        case errno.EBUSY | errno.EAGAIN:
            return "busy"
        case _:
            return "unreachable"


def is_settling(path: str) -> bool:
    """Return whether a device file appeared or changed its rights so recently that udev may not have finished."""
    try:
        return abs(time.time() - Path(path).stat().st_ctime) < SETTLED_S
    except OSError:
        return False
