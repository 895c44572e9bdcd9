"""Runs a program with the system calls that a unit's lines leave it: `under_filter.py 'NAME NAME …' PROGRAM ARGUMENT…`."""

import ctypes
import ctypes.util
import errno
import os
import sys

PR_SET_NO_NEW_PRIVS = 38
ALLOW, ERRNO = 0x7FFF0000, 0x00050000
UNKNOWN_HERE = -1
"""What libseccomp answers for a call that no architecture has; others that are not this one's are smaller."""


def main() -> None:
    """Allow the calls that are named, refuse all others with EPERM, and become the program."""
    library = ctypes.CDLL(ctypes.util.find_library("seccomp"), use_errno=True)
    library.seccomp_init.restype = ctypes.c_void_p
    context = ctypes.c_void_p(library.seccomp_init(ctypes.c_uint32(ERRNO | errno.EPERM)))
    for name in sys.argv[1].split():
        number = library.seccomp_syscall_resolve_name(name.encode())
        if number > UNKNOWN_HERE:
            must(library.seccomp_rule_add(context, ctypes.c_uint32(ALLOW), number, 0), name)
    must(ctypes.CDLL(None).prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0), "no new privileges")
    must(library.seccomp_load(context), "the filter")
    os.execv(sys.argv[2], sys.argv[2:])


def must(result: int, what: str) -> None:
    """Exit with what failed."""
    if result:
        sys.exit(f"{what}: {result}")


main()
