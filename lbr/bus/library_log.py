"""The log lines of the bus library, which are the only report of some events at a router."""

import contextlib
import fcntl
import os
import select
import sys

import zenoh

LOUDNESS = "RUST_LOG"
PIPE_BYTES = 1 << 20
ACCEPTED = "zenoh_link_tls=debug,zenoh_link_tcp=debug,zenoh_transport::unicast::establishment::accept=debug"
"""The parts of the library that report accepted or refused connections."""


class LibraryLog:
    """Replaces this process's standard output, to which the library writes, by a pipe; to be made once, before any
    session.

    The library never waits for the reader: lines that do not fit into the pipe are lost. The pipe holds a mebibyte if
    permitted.
    """

    def __init__(self, parts: str) -> None:
        self._fd, write_end = os.pipe()
        os.set_blocking(self._fd, False)
        os.set_blocking(write_end, False)
        with contextlib.suppress(OSError):  # a user with many pipes may have no large one
            fcntl.fcntl(write_end, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
        sys.stdout.flush()
        os.dup2(write_end, 1)
        os.close(write_end)
        self._rest = b""
        os.environ[LOUDNESS] = parts  # alone: other words, unknown to the library, silence it
        zenoh.try_init_log_from_env()

    def wait(self, timeout_s: float) -> list[str]:
        """Wait for a line; return the new ones."""
        if not select.select([self._fd], [], [], timeout_s)[0]:
            return []
        *lines, rest = (self._rest + os.read(self._fd, PIPE_BYTES)).split(b"\n")
        self._rest = rest[-PIPE_BYTES:]
        return [line.decode(errors="replace") for line in lines]
