"""Confines a process before it does anything: Linux capabilities, new privileges, core dumps, access to its files.

Imports nothing of the project, so that a program's tether can use it, too. To be called while there is one thread.
"""

import ctypes
import os
import resource
from collections.abc import Iterable
from pathlib import Path

PR_SET_DUMPABLE, PR_CAPBSET_DROP, PR_SET_NO_NEW_PRIVS, PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL = 4, 24, 38, 47, 4
CAPABILITY_VERSION_3 = 0x20080522
CAP_DAC_OVERRIDE = 1
LAST_CAPABILITY = 63
OWNER_ONLY = 0o077


def confine(places: Iterable[str] = ()) -> None:
    """Give up all rights; `places` are the files and directories that must stay accessible.

    Root keeps one right, to open the files of others (CAP_DAC_OVERRIDE), if another user owns one of the places. This
    may be a home that is mounted into a container, or a device.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    rights = {CAP_DAC_OVERRIDE} if needs_override(places) else set()
    for number in range(LAST_CAPABILITY + 1):
        if number not in rights:
            libc.prctl(PR_CAPBSET_DROP, number, 0, 0, 0)  # a process without rights may not do this
    libc.prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL, 0, 0, 0)
    _set_capabilities(libc, rights)
    _must(libc.prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0), "new privileges cannot be refused")
    keep_private()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def keep_private() -> None:
    """Keep others from reading this process's files and memory."""
    os.umask(OWNER_ONLY)
    ctypes.CDLL(None).prctl(PR_SET_DUMPABLE, 0, 0, 0, 0)


def needs_override(places: Iterable[str]) -> bool:
    """Return whether root must keep the right to open the files of others in order to reach all of these."""
    return os.geteuid() == 0 and any(Path(place).exists() and Path(place).stat().st_uid != 0 for place in places)


def _set_capabilities(libc: ctypes.CDLL, kept: set[int]) -> None:
    low, high = (sum(1 << number % 32 for number in kept if number // 32 == half) for half in (0, 1))
    header = (ctypes.c_uint32 * 2)(CAPABILITY_VERSION_3, 0)
    data = (ctypes.c_uint32 * 6)(low, low, 0, high, high, 0)
    _must(libc.capset(header, data), "capabilities cannot be given up")


def _must(result: int, trouble: str) -> None:
    if result != 0:
        raise OSError(ctypes.get_errno(), trouble)
