"""The environment of a process from the shell that starts it: standard streams, and limits. A fault is one sentence."""

import contextlib
import errno
import os
import resource
import select
import signal
import stat
import sys
from collections.abc import Iterable
from pathlib import Path

from lbr.errors import InputError

OPEN_FILES = 1024
"""The limit of a system that sets no limit of its own."""
LEAST_OPEN_FILES = 64
ROBOT_OPEN_FILES = 256
"""Twice the open files of the largest shipped robot, so that others may connect to it."""
ROBOT_FILE_BYTES = 64 * 1024 * 1024
"""Logs are cut at 2 MB; a database and its write-ahead log may grow as much as the audit trail."""
ROBOT_TASKS = 64
"""Enough for the executive and a few processes; the simulated lbr has 138 on two cores."""

HEAPS = 2
"""Of glibc, in a process that routes.

Each broken link leaves holes in the heap of each thread that served it; by default there are eight heaps for each
processor. After all links broke 20 times, that took 16 MiB, and 8 with two heaps.
"""
M_ARENA_MAX = -8
"""Of `mallopt`, from glibc's malloc.h."""


def plug_streams() -> None:
    """Open closed standard streams, so that no file of ours takes their place.

    Reads are empty, prints fail as they should, and error messages are lost.
    """
    for fd, mode, name in ((0, "r", "stdin"), (1, "w", "stdout"), (2, "w", "stderr")):
        if _is_open(fd):
            continue
        plug = os.open(os.devnull, os.O_RDONLY if fd == 1 else os.O_WRONLY)
        if plug != fd:
            os.dup2(plug, fd)
            os.close(plug)
        setattr(sys, name, open(fd, mode, closefd=False, encoding="utf-8"))  # noqa: SIM115 - it stays open


def note_signals() -> None:
    """Have Python note each signal in a file from now on, as some C code drops the exceptions of signal handlers.

    The file has no name. A later handler gets it from `signal.set_wakeup_fd`, and closes it.
    """
    noted = os.memfd_create("signals")
    os.set_blocking(noted, False)
    signal.set_wakeup_fd(noted, warn_on_full_buffer=False)


def interrupt_by_signals() -> None:
    """Let SIGTERM and SIGHUP interrupt as Ctrl-C does; a SIGHUP that `nohup` ignores stays ignored."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) == signal.SIG_DFL:
            signal.signal(number, signal.default_int_handler)


def lift_limits() -> None:
    """Raise soft limits as far as the hard ones permit; raise InputError if they are too low for any command."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if 0 <= soft < OPEN_FILES:
        with contextlib.suppress(ValueError, OSError):
            most = OPEN_FILES if hard < 0 else min(hard, OPEN_FILES)
            resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, most), hard))
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    if soft != hard:
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
    _need_open_files(LEAST_OPEN_FILES, "lbr")


def forget_runtime() -> None:
    """Remove the shell's setting for the threads of the bus library; to be called before that is loaded.

    A router with too few threads collapses, and with an invalid setting it does not start.
    """
    os.environ.pop("ZENOH_RUNTIME", None)


def bound_heaps() -> None:
    """Give this process's threads a few common heaps; call it before there are threads. It only affects glibc."""
    import ctypes  # noqa: PLC0415 - light commands need none of it

    with contextlib.suppress(AttributeError, OSError):
        ctypes.CDLL(None).mallopt(M_ARENA_MAX, HEAPS)


def need_room_for_a_robot() -> None:
    """Raise InputError if limits are too low for a robot's files."""
    _need_open_files(ROBOT_OPEN_FILES, "a robot")
    most, _ = resource.getrlimit(resource.RLIMIT_FSIZE)
    if 0 <= most < ROBOT_FILE_BYTES:
        raise InputError(
            f"files may not grow beyond {most} bytes here, and a robot's may need {ROBOT_FILE_BYTES}: "
            "say 'ulimit -f unlimited' first, or have the hard limit raised (LimitFSIZE= of a service)"
        )
    tasks, _ = resource.getrlimit(resource.RLIMIT_NPROC)
    if 0 <= tasks < ROBOT_TASKS and os.geteuid() != 0:  # root has no such limit
        raise InputError(
            f"this user may have {tasks} threads and processes, and a robot needs {ROBOT_TASKS} at least: "
            "say 'ulimit -u unlimited' first, or have the hard limit raised (LimitNPROC= of a service)"
        )


def need_a_console() -> None:
    """Raise InputError if there is no input for lines, or no output for results."""
    how = "'lbr run --no-console' runs a robot without one, and a terminal has both"
    if not can_write(1):
        raise InputError(f"standard output is closed, and a console prints there: {how}")
    if _at_end(0):
        raise InputError(f"standard input is empty, and its end shuts a robot down that has a console: {how}")


def can_write(fd: int) -> bool:
    """Return whether a descriptor is open for writing."""
    import fcntl  # noqa: PLC0415 - light commands need none of it

    try:
        return fcntl.fcntl(fd, fcntl.F_GETFL) & os.O_ACCMODE != os.O_RDONLY
    except OSError:
        return False


def explained(err: OSError) -> str:
    """Return the cure of an error of the surroundings; empty for another error."""
    if why := output_failure(probe=True):
        return why
    what = f"{os.fsdecode(err.filename)}: " if isinstance(err.filename, str | bytes) else ""
    if err.errno in {errno.EMFILE, errno.ENFILE}:
        most, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
        whose = "too many files are open on this machine"
        if err.errno == errno.EMFILE:
            whose = f"{most} files are open, the most for this process"
        return f"{what}{whose}: 'ulimit -n {OPEN_FILES}' allows more"
    lift = "'ulimit -f unlimited' lifts it"
    size = {
        errno.EFBIG: f"{what}a file or standard output would grow beyond the limit of this process: {lift}",
        errno.ENAMETOOLONG: f"{what[:60]}…: {err.strerror}; give it a shorter one",
    }
    if err.errno in size:
        return size[err.errno]
    if err.errno in {errno.ENOSPC, errno.EDQUOT}:
        room = "there is no room left on the disk: make some, or set LBR_HOME to another one"
        return f"{what or 'standard output or a file of its own: '}{room}"
    return _in_the_way(err, what) if what else ""


def _in_the_way(err: OSError, what: str) -> str:
    if err.errno in {errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOTDIR, errno.EISDIR}:
        return f"{what}{err.strerror}; give yourself the right to it, or set LBR_HOME to a directory of your own"
    stray = err.errno == errno.ENOENT and Path(os.fsdecode(err.filename)).is_symlink()
    if stray or err.errno in {errno.EEXIST, errno.ELOOP}:
        return f"{what}{err.strerror}; something stands in its place, or a link that leads nowhere: move that away"
    return ""


def output_failure(*, probe: bool = False) -> str:
    """Return why standard output rejects what was printed, empty if it does not.

    `probe` also tries it if nothing is left to print.
    """
    try:
        sys.stdout.flush()
        if probe:
            os.write(1, b"")
    except OSError as err:
        if err.errno == errno.EBADF:
            return "standard output is closed: give it a terminal, a file or /dev/null"
        if err.errno == errno.EPIPE:
            return ""
        return f"standard output cannot be written ({err.strerror}): give it a file with room, or /dev/null"
    except ValueError:
        return ""
    return ""


def drop_output(fds: Iterable[int] = (1, 2)) -> None:
    """Redirect standard output and error to nowhere, so that the interpreter's end waits for no reader."""
    with contextlib.suppress(OSError):
        nowhere = os.open(os.devnull, os.O_WRONLY | os.O_CLOEXEC)
        for fd in fds:
            os.dup2(nowhere, fd)
        os.close(nowhere)


def _need_open_files(least: int, who: str) -> None:
    most, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    if 0 <= most < least:
        raise InputError(
            f"this process may open {most} files, and {who} needs {least}: "
            f"say 'ulimit -n {OPEN_FILES}' first, or have the hard limit raised (LimitNOFILE= of a service)"
        )


def _is_open(fd: int) -> bool:
    try:
        os.fstat(fd)
    except OSError:
        return False
    return True


def _at_end(fd: int) -> bool:
    """Return whether reading from a descriptor would give its end at once."""
    try:
        about = os.fstat(fd)
        if stat.S_ISCHR(about.st_mode):
            return not os.isatty(fd) and about.st_rdev == Path(os.devnull).stat().st_rdev
        if stat.S_ISREG(about.st_mode):
            return os.lseek(fd, 0, os.SEEK_CUR) >= about.st_size
    except OSError:
        return True
    poll = select.poll()
    poll.register(fd, select.POLLIN)
    return any(event & select.POLLHUP and not event & select.POLLIN for _, event in poll.poll(0))
