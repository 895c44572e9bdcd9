"""A process of capabilities: `python -m lbr.capability.process`, started by the executive.

    executive ── Order, by standard input ──► main thread ──► a thread for each loop ── Report, by number ──► executive

An order starts a capability, or ends one. Most processes get only one capability. Standard input stays open as the
lifeline: when it closes, the executive has ended. Then the process stops its motion and ends, even after a freeze.

Capabilities of one process share the interpreter, the session on the bus and its rights there. Each ends when asked to,
without the others. A failure ends all of them, because the state of the process is unknown then. A capability that
fails before it begins has done nothing, and ends alone. Every exit except a requested stop is `os._exit(70)`: a thread
of the bus library would keep the process alive after Python's end.
"""

import contextlib
import os
import select
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from types import FrameType

import msgspec

from lbr.bus import wire
from lbr.capability import leaving, lifeline
from lbr.capability.config import Order, ProcessConfig
from lbr.capability.confine import confine
from lbr.capability.loop import Garbage, Loop
from lbr.capability.reporter import HEARTBEAT_VARIABLE, Phase, Reporter

PART_OF_CLOSING = 0.8
"""The share of the time to leave in which the other loops may end in order."""
SWITCH_S = 0.0005
"""A waiting loop gets the interpreter after this time. Python's default, 5 ms, is as long as a whole command.

The slowest of a hundred commands reached the motors after 5 ms instead of 8, the usual one no later.
"""


class Member:
    """A capability of this process. `run(member)` runs it in its own thread."""

    def __init__(
        self, number: int, config: ProcessConfig, fd: int, garbage: Garbage, run: "Callable[[Member], None]"
    ) -> None:
        self.number = number
        self.reporter = Reporter(fd, number)
        self.loop = Loop(config, self.reporter, garbage)
        self.thread = threading.Thread(target=run, args=(self,), name=config.name, daemon=True)


class ProcessHost:
    """Runs capabilities. `stop` may be called by a signal handler. `fd` is the pipe of reports."""

    def __init__(self, fd: int) -> None:
        self._fd = fd
        self._garbage = Garbage()
        self._members: dict[int, Member] = {}
        self._confined = self._stopping = False
        self._crashing = threading.Lock()

    def obey(self, order: Order) -> None:
        """Carry out an order. Nothing starts once all are to end."""
        if order.start is None:
            if order.number in self._members:
                self._members[order.number].loop.stop()
        elif not self._stopping:
            self._begin(order.number, order.start)

    def stop(self) -> None:
        """Ask all capabilities to end, and the process with the last one."""
        self._stopping = True
        for member in list(self._members.values()):
            member.loop.stop()
        self._leave_with_the_last()

    def wait(self) -> None:
        """Wait until all have ended."""
        for member in list(self._members.values()):
            member.thread.join()

    def crash(self, err: BaseException, of: Member | None = None) -> None:
        """End the process, each loop in order as far as the time allows. Never return."""
        self._crashing.acquire()
        try:
            leaving.within(leaving.CLOSE_LIMIT_S)
            members = list(self._members.values())
            for member in [of] if of is not None else members:
                member.reporter.phase("failed", leaving.text(err), "failed")
            for member in members:
                member.loop.stop()
            leaving.trace(err)
            if of is not None:
                with contextlib.suppress(Exception):  # its failure is reported already, and the others must still end
                    of.loop.close()
            until = time.monotonic() + PART_OF_CLOSING * leaving.CLOSE_LIMIT_S
            for member in members:
                if member.thread is not threading.current_thread() and member.thread.is_alive():
                    member.thread.join(max(0.0, until - time.monotonic()))
        finally:
            os._exit(leaving.CRASHED)

    def _begin(self, number: int, config: ProcessConfig) -> None:
        member = self._members[number] = Member(number, config, self._fd, self._garbage, self._run)
        if not self._confined:
            self._confined = True
            confine(config.places)
        if len(self._members) > 1:
            sys.setswitchinterval(SWITCH_S)
        try:
            member.thread.start()
        except RuntimeError as err:  # this machine starts no more threads now
            self._remove(member, _not_begun(err))

    def _run(self, member: Member) -> None:
        try:
            member.reporter.begins()
            member.loop.run()
        except BaseException as err:  # noqa: BLE001 - this thread's outermost frame: stop the motion and leave
            if member.loop.began:
                self.crash(err, member)
            ended: Phase = _not_begun(err)
        else:
            ended = "ended", "", ""
        if not self._crashing.locked():  # in a crash, only its cause is reported
            self._remove(member, ended)

    def _remove(self, member: Member, ended: Phase) -> None:
        member.reporter.phase(*ended)
        del self._members[member.number]
        self._leave_with_the_last()

    def _leave_with_the_last(self) -> None:
        if self._stopping and not self._members:
            os._exit(0)


def _not_begun(err: BaseException) -> Phase:
    """Log why a capability did not begin, and return the phase to report."""
    leaving.trace(err)
    return "left", leaving.text(err), "failed"


def _orders(signals: int) -> Iterator[Order]:
    """Yield the orders on standard input, line by line, until it closes. `signals` ends a wait when a signal comes."""
    decoder = msgspec.json.Decoder(Order)
    poll = select.poll()
    for fd in (0, signals):
        poll.register(fd, select.POLLIN)
    rest = b""
    while True:
        ready = {fd for fd, _ in poll.poll()}
        if signals in ready:
            os.read(signals, 4096)  # the handler has run
        if 0 in ready:
            if not (part := os.read(0, 65536)):
                return
            *lines, rest = (rest + part).split(b"\n")
            yield from map(decoder.decode, lines)


def _heed(host: ProcessHost) -> int:
    """End when asked by a signal. Return a pipe that reports signals.

    The kernel may choose any thread, and the main thread runs the handler: the pipe wakes it.
    """

    def stop(_signal: int, _frame: FrameType | None) -> None:
        host.stop()

    signals, noted = os.pipe()
    os.set_blocking(noted, False)
    signal.set_wakeup_fd(noted, warn_on_full_buffer=False)
    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all processes of the terminal; the executive decides
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    return signals


def main() -> None:
    """Carry out orders, and end the process for certain."""
    host = ProcessHost(int(os.environ[HEARTBEAT_VARIABLE]))
    try:
        wire.on_callback_error = host.crash
        threading.excepthook = lambda args: host.crash(args.exc_value or RuntimeError("thread died"))
        lifeline.wake(0, os.getpid())
        for order in _orders(_heed(host)):
            host.obey(order)
        leaving.within(2 * leaving.CLOSE_LIMIT_S)
        host.stop()
        host.wait()
    except BaseException as err:  # noqa: BLE001 - the outermost frame: whatever it is, stop the motion and leave
        host.crash(err)
    os._exit(0)


if __name__ == "__main__":
    main()
