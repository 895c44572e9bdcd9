"""Lines from a pipe or the command line: one after the other, each motion held until its end."""

import contextlib
import math
import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from concurrent import futures
from typing import IO

from lbr.console.lease_keeper import Ending, LeaseKeeper
from lbr.console.operator import BusOperator
from lbr.console.stops import is_stop
from lbr.errors import BusError, InputError, LbrError
from lbr.messages.plain import one_line
from lbr.messages.system import ConsoleResult

FAILED, BAD_INPUT = 1, 2
DROPPED_TOLD = 4
POLL_S = 0.05
ENDING_S = 0.5
"""The time for the answer to the line that ends the robot, which comes while the console ends; a shutdown has 2.5 s."""


class Read(str):
    """A line, and when it was read, by the monotonic clock; for a script, the time before all of it began."""

    __slots__ = ("at",)

    at: float


def read(text: str, at: float) -> Read:
    """Return a line with the time at which it was read."""
    line = Read(text)
    line.at = at
    return line


class Lines:
    """Sends lines in order, except empty ones and comments (`# …`), and waits for bounded motions.

    An unbounded motion is held for `hold_s` if that is given. Otherwise it ends when a later line moves or stops the
    robot, or when the input ends. A stop waits neither for a motion's end nor for earlier lines: those that are not
    sent yet are dropped. Each line carries its waiting time: movers refuse a line that was written before somebody else
    stopped the robot.
    """

    def __init__(self, operator: BusOperator, out: IO[str], err: IO[str], *, hold_s: float | None = None) -> None:
        self._operator = operator
        self._out = out
        self._err = err
        self._hold_s = hold_s
        self._worst = 0
        self.closing = False
        self._waiting: queue.SimpleQueue[tuple[float, str | None]] = queue.SimpleQueue()
        self._next: deque[tuple[float, str | None]] = deque()
        self._began = math.inf

    def run(self, lines: Iterable[str]) -> int:
        """Send every line; return the worst line's exit code."""
        threading.Thread(target=self._read, args=(lines,), name="lines", daemon=True).start()
        try:
            while (taken := self._take()) is not None:
                self._say(*taken)
            self._out.flush()
        finally:
            self._operator.release()
        return self._worst

    def close(self) -> None:
        """End `run` from another thread; a held motion is stopped."""
        self.closing = True
        self._waiting.put((time.monotonic(), None))

    def _read(self, lines: Iterable[str]) -> None:
        try:
            for line in lines:
                if line.strip() and not line.lstrip().startswith("#"):
                    self._waiting.put((time.monotonic(), line))
        finally:
            self._waiting.put((time.monotonic(), None))

    def _take(self) -> tuple[float, str] | None:
        """Return the time of the next line, and the line; None at the end."""
        while not self._peek():
            self._operator.ear.beat()
        came, line = self._next.popleft()
        return None if self.closing or line is None else (came, line)

    def _peek(self) -> bool:
        """Return whether a next line (or the end) has come, after a short wait."""
        if self._next:
            return True
        try:
            self._next.append(self._waiting.get(timeout=POLL_S))
        except queue.Empty:
            return False
        return True

    def _say(self, came: float, line: str) -> None:
        self._began = time.monotonic()
        try:
            result = self._submitted(line, came)
        except LbrError as err:
            self._failed(one_line(str(err)), BAD_INPUT if isinstance(err, InputError) else FAILED)
            return
        show(result, self._out, self._err)
        self._worst = max(self._worst, result.code)
        held = self._operator.latest()
        if held is None or held.hold is not result.hold:
            return
        ending = self._hold(held)
        if ending is not None and ending.good:
            print(ending.text, file=self._out, flush=True)
        elif ending is not None:
            self._failed(ending.text, FAILED)

    def _submitted(self, line: str, came: float) -> ConsoleResult:
        """Send a line and return its result; a stop that comes meanwhile is sent at once."""
        result: futures.Future[ConsoleResult] = futures.Future()

        def submit() -> None:
            try:
                result.set_result(self._operator.submit(line, time.monotonic() - came))
            except BaseException as err:  # noqa: BLE001 - it belongs to the thread that waits
                result.set_exception(err)

        threading.Thread(target=submit, name="console line", daemon=True).start()
        while not self.closing:
            futures.wait([result], POLL_S)
            if result.done():
                return result.result()
            self._operator.ear.beat()
            if self._is_stop():
                came_stop, stop = self._next.popleft()
                self._say(came_stop, str(stop))
        futures.wait([result], ENDING_S)
        if result.done():
            return result.result()
        raise BusError("the console ends; the answer was not waited for")

    def _hold(self, held: LeaseKeeper) -> Ending | None:
        until = time.monotonic() + self._hold_s if self._hold_s is not None else None
        while held.ending is None and not self.closing:
            self._operator.ear.beat()
            ready = self._peek()
            if self._is_stop():
                return None
            if not held.hold.goal and self._is_over(until, ready=ready):
                return None if ready and self._next[0][1] is not None and self._hold_s is None else self._release(held)
            if ready:
                held.wait(POLL_S)
        return held.ending

    def _is_stop(self) -> bool:
        """Return whether the next line is a stop; a stop that came after the line under way counts as the next."""
        with contextlib.suppress(queue.Empty):
            while True:
                self._next.append(self._waiting.get_nowait())
        for place, (_came, line) in enumerate(self._next):
            if line is not None and is_stop(line) and (place == 0 or getattr(line, "at", 0.0) > self._began):
                self._drop(place)
                return True
        return False

    def _drop(self, count: int) -> None:
        dropped = [one_line(str(self._next.popleft()[1]).strip()) for _ in range(count)]
        if dropped:
            more = f" and {count - DROPPED_TOLD} more" if count > DROPPED_TOLD else ""
            self._failed(f"a stop came, so these lines are not sent: {', '.join(dropped[:DROPPED_TOLD])}{more}", FAILED)

    def _is_over(self, until: float | None, *, ready: bool) -> bool:
        return ready if until is None else not time.monotonic() < until

    def _release(self, held: LeaseKeeper) -> Ending | None:
        self._operator.release("the input ended" if self._hold_s is None else f"the {self._hold_s:g} s are over")
        return Ending(good=True, text=f"stopped after {held.elapsed_s:.1f} s")

    def _failed(self, text: str, code: int) -> None:
        self._worst = max(self._worst, code)
        print(text, file=self._err, flush=True)


def show(result: ConsoleResult, output: IO[str], errors: IO[str]) -> None:
    """Print a result on the right stream, without control characters."""
    text = "\n".join(one_line(part) for part in result.text.splitlines())
    if text:
        print(text, file=errors if result.code else output, flush=True)


Announce = Callable[[ConsoleResult], None]


def say_once(
    operator: BusOperator, line: str, *, hold_s: float, announce: Announce, beat: Callable[[], None] | None = None
) -> tuple[ConsoleResult, int, Ending | None]:
    """Send one line and wait for the end of its motion; return its result, the exit code, and the motion's end.

    `beat` replaces the beats of this thread, if another one receives stops.
    """
    beat = beat or operator.ear.beat
    result = operator.submit(line)
    announce(result)
    held = operator.latest()
    if held is None or held.hold is not result.hold:
        return result, result.code, None
    until = time.monotonic() + (hold_s if not held.hold.goal else math.inf)
    while (ending := held.wait(min(POLL_S, max(0.0, until - time.monotonic())))) is None and time.monotonic() < until:
        beat()
    if ending is None:
        operator.release(f"the {hold_s:g} s are over")
        text = f"stopped after {held.elapsed_s:.1f} s"
        return result, result.code, Ending(good=True, text=text, code="stopped")
    return result, (result.code if ending.good else FAILED), ending
