"""Several capabilities in one process: each has its loop in a thread of its own, and what ends one unasked ends all.

    executive ── Order, by standard input ──► main thread ──► a thread for each loop ── Report, with its name ──► executive

They share the interpreter, the session on the bus and its rights there. Each ends when it is asked to, without the
others; what fails takes them along, because nobody knows what of the process is still good. One that does not even
begin has done nothing, and leaves alone.
"""

import contextlib
import os
import sys
import threading
import time
from collections.abc import Callable

import msgspec

from lbr.capability import leaving
from lbr.capability.config import Order, ProcessConfig
from lbr.capability.loop import Garbage, Loop
from lbr.capability.reporter import Reporter, Said

PART_OF_CLOSING = 0.8
"""How much of the time to leave the others get to end in order."""
SWITCH_S = 0.0005
"""So soon a loop gets the interpreter that another goes on using: the slowest of a hundred commands came to the motors
after 5 ms instead of 8, and the usual one no later. Python's own 5 ms is as long as a command takes in all."""
_orders = msgspec.json.Decoder(Order)


class Member:
    """A capability that runs here, in a thread of its own: `run(member)`."""

    def __init__(self, config: ProcessConfig, fd: int, garbage: Garbage, run: "Callable[[Member], None]") -> None:
        self.name = config.name
        self.reporter = Reporter(fd, config.name)
        self.loop = Loop(config, self.reporter, garbage)
        self.thread = threading.Thread(target=run, args=(self,), name=config.name, daemon=True)


class SharedProcess:
    """Obeys in one thread; `stop` may come from a signal handler. `fd` is the pipe of reports."""

    def __init__(self, fd: int) -> None:
        self._fd = fd
        self._garbage = Garbage()
        self._members: dict[str, Member] = {}
        self._stopping = False
        self._crashing = threading.Lock()
        sys.setswitchinterval(SWITCH_S)

    def obey(self, line: bytes) -> None:
        """Do what an order says."""
        order = _orders.decode(line)
        if order.start is not None:
            self.begin(order.start)
        if order.stop in self._members:
            self._members[order.stop].loop.stop()

    def begin(self, config: ProcessConfig) -> None:
        """Let one more capability run; one of its name has ended before. None begins where all are to end."""
        if self._stopping:
            return
        member = self._members[config.name] = Member(config, self._fd, self._garbage, self._run)
        try:
            member.thread.start()
        except RuntimeError as err:  # this machine gives no more threads now
            self._gone(member, _left(err))

    def stop(self) -> None:
        """Ask all of them to end, and the process with the last of them."""
        self._stopping = True
        for member in list(self._members.values()):
            member.loop.stop()
        self._leave_with_the_last()

    def wait(self) -> None:
        """Return when all have ended."""
        for member in list(self._members.values()):
            member.thread.join()

    def crash(self, err: BaseException, of: Member | None = None) -> None:
        """End the process, with each loop as far as there is time. Never returns."""
        self._crashing.acquire()
        try:
            leaving.within(leaving.CLOSE_LIMIT_S)
            members = list(self._members.values())
            for member in [of] if of is not None else members:
                member.reporter.phase("failed", leaving.told(err), "failed")
            for member in members:
                member.loop.stop()
            leaving.trace(err)
            if of is not None:
                with contextlib.suppress(Exception):  # it has failed already, and the others are still to end
                    of.loop.close()
            until = time.monotonic() + PART_OF_CLOSING * leaving.CLOSE_LIMIT_S
            for member in members:
                if member.thread is not threading.current_thread() and member.thread.is_alive():
                    member.thread.join(max(0.0, until - time.monotonic()))
        finally:
            os._exit(leaving.CRASHED)

    def _run(self, member: Member) -> None:
        try:
            member.reporter.begins()
            member.loop.run()
        except BaseException as err:  # noqa: BLE001 - this thread's outermost frame: stop the motion and leave
            if member.loop.began:
                self.crash(err, member)
            ended: Said = _left(err)
        else:
            ended = "ended", "", ""
        if not self._crashing.locked():  # the process ends: who made it end is told, not this
            self._gone(member, ended)

    def _gone(self, member: Member, ended: Said) -> None:
        del self._members[member.name]
        member.reporter.phase(*ended)
        self._leave_with_the_last()

    def _leave_with_the_last(self) -> None:
        if self._stopping and not self._members:
            os._exit(0)


def _left(err: BaseException) -> Said:
    """Return what is reported of one that did not begin, and write down why."""
    leaving.trace(err)
    return "left", leaving.told(err), "failed"
