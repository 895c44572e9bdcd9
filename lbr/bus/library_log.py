"""The log of the bus library, as lines: the only report of some events at a router."""

import contextlib
import fcntl
import os
import select
import sys

import zenoh

LOUDNESS = "RUST_LOG"
PIPE_BYTES = 1 << 20
ACCEPTED = "zenoh_link_tls=debug,zenoh_link_tcp=debug,zenoh_transport::unicast::establishment::accept=debug"
"""The parts of the library that report connections, admitted or refused."""


class LibraryLog:
    """Turns this process's standard output, where the library writes, into a pipe; to be made once, before any session.

    The library never waits for the reader: what does not fit into the pipe, a mebibyte if there may be such, is lost.
    """

    def __init__(self, parts: str) -> None:
        self._fd, write_end = os.pipe()
        os.set_blocking(self._fd, False)
        os.set_blocking(write_end, False)
        with contextlib.suppress(OSError):  # a user who has many pipes may have no large one
            fcntl.fcntl(write_end, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
        sys.stdout.flush()
        os.dup2(write_end, 1)
        os.close(write_end)
        self._rest = b""
        os.environ[LOUDNESS] = parts  # alone: beside words that the library does not understand it would say nothing
        zenoh.try_init_log_from_env()

    def wait(self, timeout_s: float) -> list[str]:
        """Return the lines that came, waiting for the first."""
        if not select.select([self._fd], [], [], timeout_s)[0]:
            return []
        *lines, rest = (self._rest + os.read(self._fd, PIPE_BYTES)).split(b"\n")
        self._rest = rest[-PIPE_BYTES:]
        return [line.decode(errors="replace") for line in lines]
