"""Forks the processes of capabilities from an interpreter that has imported their common modules.

    executive ── ForkOrder: words, environment, standard input, log, pipe of reports ──► fork server ── fork ──► process
              ◄── ForkReply: its number, by itself, once it leads its session ────────────────────────────────────┘
              ◄── ForkReply: how it ended; ForkOrder to release it: only then is its number free ──► fork server

`python -P -m lbr.capability.fork_server FD KINDS ROOM`, where FD is a socket that separates messages. Before a fork,
there must be neither a thread nor a session of the bus. When the executive is gone, this process ends; the forked ones
have lifelines of their own. All of them have the same addresses in memory: an attacker who knows one process's layout
knows all.
"""

import ctypes
import gc
import os
import select
import signal
import socket
import sys
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path

import msgspec
from msgspec import Struct

from lbr import plugins
from lbr.capability import leaving, lifeline, process, registry
from lbr.capability.kind import KindError
from lbr.capability.reporter import HEARTBEAT_VARIABLE

LARGEST = 1 << 17
"""Of a message, in bytes; less than the kernel accepts at once."""
ROOM = 160
"""For the arguments of forked processes, in bytes: a robot's and a capability's name, and a home."""
IGNORED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""It ends with the executive, and not before."""


class ForkOrder(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """An order to fork a process with these arguments and environment, or to release the number of an ended one."""

    words: tuple[str, ...] = ()
    environment: dict[str, str] = {}
    release: int = 0


class ForkReply(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """All imports are done (no field), a process has started (its number) or ended (its code), or the trouble."""

    pid: int = 0
    code: int | None = None
    trouble: str = ""


class Server:
    """Serves orders until the other end is gone."""

    def __init__(self, link: socket.socket) -> None:
        self._link = link
        self._poll = select.poll()
        self._poll.register(link, select.POLLIN)
        self._running: dict[int, int] = {}

    def serve(self) -> None:
        """Serve, and return when the executive is gone."""
        self._say(ForkReply())
        while True:
            for fd, _ in self._poll.poll():
                if fd != self._link.fileno():
                    self._ended(fd)
                    continue
                content, fds, _, _ = socket.recv_fds(self._link, LARGEST, 3)
                if not content:
                    return
                self._obey(msgspec.json.decode(content, type=ForkOrder), fds)

    def _obey(self, order: ForkOrder, fds: list[int]) -> None:
        if order.release:
            with suppress(ChildProcessError):
                os.waitpid(order.release, 0)
            return
        try:
            pid = os.fork()
            if pid == 0:
                become(order, fds, self._link)
            fd = os.pidfd_open(pid)
            self._running[fd] = pid
            self._poll.register(fd, select.POLLIN)
        except OSError as err:
            self._say(ForkReply(trouble=str(err)))
        finally:
            for one in fds:
                os.close(one)

    def _ended(self, fd: int) -> None:
        self._poll.unregister(fd)
        os.close(fd)
        found = os.waitid(os.P_PID, self._running.pop(fd), os.WEXITED | os.WNOWAIT)
        if found is not None:
            code = found.si_status if found.si_code == os.CLD_EXITED else -found.si_status
            self._say(ForkReply(pid=found.si_pid, code=code))

    def _say(self, what: ForkReply) -> None:
        self._link.send(msgspec.json.encode(what))


def become(order: ForkOrder, fds: list[int], link: socket.socket) -> None:
    """Continue as the ordered process; never returns."""
    try:
        os.setsid()
        for number in IGNORED:
            signal.signal(number, signal.SIG_DFL)
        stdin, log, reports = fds
        for ours, theirs in ((stdin, 0), (log, 1), (log, 2)):
            os.dup2(ours, theirs)
        os.environ.clear()
        os.environ.update(order.environment | {HEARTBEAT_VARIABLE: str(reports)})
        sys.argv = [process.__file__, *order.words]
        wear((sys.executable, "-P", "-m", process.__name__, *order.words), order.environment.get(lifeline.MARK, ""))
        link.send(msgspec.json.encode(ForkReply(pid=os.getpid())))
        for name in os.listdir("/proc/self/fd"):  # noqa: PTH208 - a name is all that is wanted
            if int(name) > 2 and int(name) != reports:
                with suppress(OSError):
                    os.close(int(name))
        process.main()
    finally:
        os._exit(leaving.CRASHED)


def wear(words: tuple[str, ...], mark: str) -> None:
    """Show arguments and mark to `ps` and the reaper, in the memory of the original ones, as far as it suffices."""
    with suppress(OSError, ValueError, IndexError):
        fields = Path("/proc/self/stat").read_bytes().rpartition(b")")[2].split()
        words_at, words_end, environment_at, environment_end = map(int, fields[45:49])
        room = words_end - words_at
        shown = b"\0".join(map(os.fsencode, words))[: room - 2] + b"\0"
        ctypes.memmove(words_at, shown + b" " * (room - len(shown) - 1) + b"\0", room)
        before = ctypes.string_at(environment_at, environment_end - environment_at)
        value = before.find(f"\0{lifeline.MARK}=".encode()) + len(lifeline.MARK) + 2
        if value > len(lifeline.MARK) + 1 and before.find(b"\0", value) - value == len(mark):
            ctypes.memmove(environment_at + value, mark.encode(), len(mark))


def prepare(kinds: Collection[str]) -> None:
    """Find packages with components, import lbr's own of these `kinds`, and their code near motion: it is shared."""
    plugins.entries()
    for point in (one for one in plugins.own("kinds") if one.name in kinds):
        with suppress(KindError):  # reported by the process that needs it
            kind = registry.declared(point)
            if kind.moves or kind.device:
                kind.load()


def main() -> None:
    """Serve. Garbage collections leave the imported modules alone from now on."""
    for number in IGNORED:
        signal.signal(number, signal.SIG_IGN)
    prepare(sys.argv[2].split(","))
    gc.collect()
    gc.freeze()
    with socket.socket(fileno=int(sys.argv[1])) as link, suppress(ConnectionError):
        Server(link).serve()


if __name__ == "__main__":
    main()
