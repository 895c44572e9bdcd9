"""The executive's side of the server that forks the processes of its capabilities.

If the server does not answer, a process starts in an interpreter of its own; that only takes longer.
"""

import contextlib
import os
import select
import socket
import subprocess
import sys
import time
from collections.abc import Collection, Mapping, Sequence
from typing import IO, Literal

import msgspec

from lbr import home
from lbr.bus.session import leaf_environment
from lbr.capability import fork_server
from lbr.capability.fork_server import LARGEST, ROOM, ForkOrder, ForkReply
from lbr.console import token_store
from lbr.errors import LbrError
from lbr.executive.processes import scheduling
from lbr.executive.processes.logs import open_log
from lbr.executive.processes.reaper import Reaper
from lbr.executive.processes.restart import UNSEEN
from lbr.messages.unreadable import UNREADABLE

BEGINS_WITHIN_S = 3.0
"""A few times its duration beside four busy loops."""
ANSWERS_WITHIN_S = 0.3
"""A fork takes 2 ms. A stop may have to wait for the process that is being forked."""
RETRY_S = 5.0


class Forked:
    """A forked process, with the interface of `subprocess.Popen`."""

    def __init__(self, server: "ForkServer", generation: int, pid: int, stdin: IO[bytes]) -> None:
        self._server = server
        self._generation = generation
        self.pid = pid
        self.stdin = stdin
        self._fd = os.pidfd_open(pid)
        self._code: int | None = None

    def poll(self) -> int | None:
        """Return its exit code, or None while it runs."""
        if self._code is None and _readable(self._fd, 0.0):
            self._code = self._server.code_of(self.pid, self._generation)
        return self._code

    def wait(self) -> int:
        """Wait for its end, and return its exit code."""
        _readable(self._fd, None)
        code = self.poll()
        return UNSEEN if code is None else code

    def close(self) -> None:
        """Release it; from then on its number may be another's."""
        os.close(self._fd)
        self._server.release(self.pid, self._generation)


class ForkServer:
    """Begins at once, and is replaced some time after it has died or did not answer. Its log is `NAME-forks.log`.

    It imports `kinds`, and the code of those near motion, which then starts sooner and is in shared memory.
    """

    def __init__(self, reaper: Reaper, name: str, kinds: Collection[str] = ()) -> None:
        self._reaper = reaper
        self._kinds = ",".join(sorted(kinds))
        self._log = home.directory("logs") / f"{name}-forks.log"
        self._state: Literal["begins", "serves", "away"] = "away"
        self._since = 0.0
        self._generation = 0
        self._codes: dict[int, int] = {}
        self._begin()

    @property
    def begins(self) -> bool:
        """Return whether it is about to serve; replace it if need be."""
        if self._state == "begins":
            self._hear(0.0)
            if self._state == "begins" and time.monotonic() - self._since > BEGINS_WITHIN_S:
                self.close()
        elif self._state == "away" and time.monotonic() - self._since > RETRY_S:
            self._begin()
        return self._state == "begins"

    @property
    def serves(self) -> bool:
        """Return whether it accepts orders."""
        return self._state == "serves"

    @property
    def pid(self) -> int:
        """Return its process number."""
        return self._popen.pid

    def fork(self, words: Sequence[str], environment: Mapping[str, str], log: int, reports: int) -> Forked | None:
        """Return a new process that waits for its document, or None if it has to be started without the server."""
        if self.begins or self._state != "serves":
            return None
        theirs, ours = os.pipe()
        stdin = os.fdopen(ours, "wb")
        try:
            order = msgspec.json.encode(ForkOrder(words=tuple(words), environment=dict(environment)))
            self._link.settimeout(ANSWERS_WITHIN_S)
            socket.send_fds(self._link, [order], [theirs, log, reports])
            reply = self._answer()
            if reply is not None and reply.pid:
                return Forked(self, self._generation, reply.pid, stdin)
        except OSError:
            self.close()
        finally:
            os.close(theirs)
        stdin.close()
        return None

    def code_of(self, pid: int, generation: int) -> int:
        """Return the exit code of an ended process; UNSEEN if the server that forked it can no longer report it."""
        until = time.monotonic() + ANSWERS_WITHIN_S
        while pid not in self._codes and self._tells_of(generation):
            if time.monotonic() > until:
                self.close()
            else:
                self._hear(until - time.monotonic())
        return self._codes.pop(pid, UNSEEN)

    def _tells_of(self, generation: int) -> bool:
        return self._state == "serves" and self._generation == generation

    def release(self, pid: int, generation: int) -> None:
        """Release the number of a process that has ended."""
        if self._tells_of(generation):
            with contextlib.suppress(OSError):
                self._link.send(msgspec.json.encode(ForkOrder(release=pid)))

    def close(self) -> None:
        """End it."""
        if self._state == "away":
            return
        self._state, self._since = "away", time.monotonic()
        self._link.close()
        self._popen.kill()
        self._popen.wait()
        self._mark.ended()

    def _answer(self) -> ForkReply | None:
        """Wait for the reply that names the new process; end a server that does not answer in time."""
        until = time.monotonic() + ANSWERS_WITHIN_S
        while self._state == "serves" and time.monotonic() < until:
            reply = self._hear(until - time.monotonic())
            if reply is not None and (reply.pid or reply.trouble):
                return reply
        self.close()
        return None

    def _hear(self, patience_s: float) -> ForkReply | None:
        """Receive one reply, and return it unless it reports the end of a process."""
        if not _readable(self._link.fileno(), max(0.0, patience_s)):
            return None
        try:
            content = self._link.recv(LARGEST)
            reply = msgspec.json.decode(content, type=ForkReply) if content else None
        except (OSError, *UNREADABLE):
            reply = None
        if reply is None:
            self.close()
        elif reply.code is not None:
            self._codes[reply.pid] = reply.code
        elif not reply.pid and not reply.trouble:
            self._state = "serves"
        return reply if reply is not None and reply.code is None else None

    def _begin(self) -> None:
        self._since = time.monotonic()
        self._generation += 1
        self._codes.clear()
        self._mark = self._reaper.mark()
        self._link, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        environment = leaf_environment() | self._mark.environment | {"LBR_HOME": str(home.home())}
        environment.pop(token_store.VARIABLE, None)
        try:
            with open_log(self._log) as log:
                self._popen = subprocess.Popen(
                    [sys.executable, "-P", "-m", fork_server.__name__, str(theirs.fileno()), self._kinds, " " * ROOM],
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=log,
                    env=environment,
                    pass_fds=(theirs.fileno(),),
                    start_new_session=True,
                )
        except (OSError, LbrError):
            self._link.close()
            return
        finally:
            theirs.close()
        self._state = "begins"
        self._mark.began(self._popen.pid)
        scheduling.rank(self._popen.pid, scheduling.MOTION)


def _readable(fd: int, patience_s: float | None) -> bool:
    """Wait until there is something to read; unlike `select`, for any number of open files."""
    poll = select.poll()
    poll.register(fd, select.POLLIN)
    return bool(poll.poll(None if patience_s is None else patience_s * 1000.0))
