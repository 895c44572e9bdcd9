"""A process's line to its executive: heartbeats from the main loop, phases, counts. Never blocks."""

import contextlib
import os
import threading
import time
from contextvars import ContextVar
from select import PIPE_BUF

import msgspec

from lbr.capability.config import Report
from lbr.messages.codes import Code, ReasonCode

Phase = tuple[str, str, ReasonCode]
"""A phase, its reason and its code."""

BEAT_S, CALM_BEAT_S = 0.2, 0.5
"""The period of heartbeats; the longer one if nothing moves by the capability, as its hang then matters less."""
EARLY_S = 0.02
"""A loop that goes round every `BEAT_S` is sometimes a little early, and still beats."""
COUNTS_S = 1.0
HEARTBEAT_VARIABLE = "LBR_HEARTBEAT_FD"
_whose: ContextVar[int] = ContextVar("whose", default=0)
"""The number of the order that started this thread's capability."""


def final_report(phase: str, reason: str, code: Code) -> tuple[int, bytes]:
    """Return the executive's pipe (-1: none), and the report that another process may write to it before it ends this
    one.

    To be called in the thread of the capability that ends.
    """
    report = Report(phase=phase, reason=reason, code=code, number=_whose.get())
    return int(os.environ.get(HEARTBEAT_VARIABLE, "-1")), _encode(report)


class Reporter:
    """Writes a capability's reports to the pipe of the executive, one line each.

    `number` is that of the order that started it, `reported` the phase that it reported last.
    """

    def __init__(self, fd: int, number: int = 0) -> None:
        self._fd = fd
        self._number = number
        self._beat_at = 0.0
        self._counts_at = 0.0
        self.reported: Phase = ("", "", "")
        self.beat_s = BEAT_S
        os.set_blocking(fd, False)

    def phase(self, phase: str, reason: str = "", code: ReasonCode = "") -> None:
        """Report a change of phase or reason."""
        if (phase, reason, code) != self.reported:
            self.reported = (phase, reason, code)
            self._write(_encode(Report(phase=phase, reason=reason[:500], code=code, number=self._number)))

    def begins(self) -> None:
        """Report the thread of the loop, which calls this."""
        _whose.set(self._number)
        self._write(_encode(Report(number=self._number, thread=threading.get_native_id())))

    def learnt(self, rows: dict[str, msgspec.Raw]) -> None:
        """Report rows to store; raise ValueError if they exceed what a pipe accepts as a whole."""
        line = _encode(Report(learnt=rows, number=self._number))
        if len(line) > PIPE_BUF:
            raise ValueError(f"rows of {len(line)} bytes are too many to learn at once: {PIPE_BUF} at most")
        self._write(line)

    def beat(self, counts: dict[str, int]) -> None:
        """Report that the main loop runs; rate-limited here, so it may be called at any rate."""
        now = time.monotonic()
        if now < self._beat_at:
            return
        self._beat_at = now + self.beat_s - EARLY_S
        if now >= self._counts_at:
            self._counts_at = now + COUNTS_S
        else:
            counts = {}
        self._write(_encode(Report(counts=counts, number=self._number, at=now)))

    def _write(self, line: bytes) -> None:
        with contextlib.suppress(OSError):  # a full or closed pipe: the lifeline shows if the executive is gone
            os.write(self._fd, line)


def _encode(report: Report) -> bytes:
    return msgspec.json.encode(report) + b"\n"
