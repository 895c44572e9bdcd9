"""Runs a program that dies with the process that started it: `python -I -S die_with_parent.py PARENT_PID HOME ARGV…`.

It takes about 10 ms, and then becomes the program itself. With a HOME the program is confined.
"""

import ctypes
import os
import signal
import sys

PR_SET_PDEATHSIG = 1


def dying_with_parent(argv: tuple[str, ...], *, within: str = "") -> list[str]:
    """Return the command line that runs `argv` for as long as this process lives, confined to the home `within`.

    Without `within`, it has this process's rights. It must be started from a thread that lives as long as the process,
    because the kernel watches the thread.
    """
    return [sys.executable, "-I", "-S", os.path.abspath(__file__), str(os.getpid()), within, *argv]  # noqa: PTH100


def main() -> None:
    """Ask the kernel for SIGKILL at the parent's death, then become the program."""
    parent, home, argv = int(sys.argv[1]), sys.argv[2], sys.argv[3:]
    ctypes.CDLL(None, use_errno=True).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)
    if home:
        _confine(home)
    signal.pthread_sigmask(signal.SIG_SETMASK, [])
    for ignored in (signal.SIGPIPE, signal.SIGXFSZ):  # ignored by Python, which the program would inherit
        signal.signal(ignored, signal.SIG_DFL)
    try:
        os.execvp(argv[0], argv)  # noqa: S606 - no shell is the point
    except OSError as err:
        sys.stderr.write(f"{argv[0]}: {err.strerror}\n")
        os._exit(127 if isinstance(err, (FileNotFoundError, NotADirectoryError)) else 126)  # the exit codes of shells


def _confine(home: str) -> None:
    sys.path.insert(0, os.path.dirname(__file__))  # noqa: PTH120 - no more imports than necessary
    from confine import confine  # type: ignore[import-not-found] # noqa: PLC0415 - the project is not on the path

    confine((home,))


if __name__ == "__main__":
    main()
