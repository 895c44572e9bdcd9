"""Speech's side of the engine's process: starts it, sends one text at a time, and ends it when it is too slow."""

import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress

import msgspec

from lbr.apps.speech.request import Answer, Request
from lbr.capability.die_with_parent import dying_with_parent
from lbr.messages.unreadable import UNREADABLE

ENGINE = (sys.executable, "-P", "-m", "lbr.apps.speech.engine")
START_S = 20.0
RETRY_FIRST_S = 1.0
RETRY_MOST_S = 30.0
ANSWER_BYTES = 65536
RESTS_AFTER_S = 10.0
"""An engine without a text for so long is ended, and the next text starts another: it has 14 MiB."""


class Worker:
    """A speech engine that restarts after a crash; nothing here blocks.

    `trouble` is why there is no engine now, or empty. One text at a time is under way; `poll` returns its result.
    """

    def __init__(self, clock: Callable[[], float], program: Sequence[str] = ENGINE) -> None:
        self.trouble = ""
        self._clock = clock
        self._program = tuple(program)
        self._popen: subprocess.Popen[bytes] | None = None
        self._received = self._text = b""
        self._greeted = self._starts = False
        self._until = self._limit_s = self._retry_at = 0.0
        self._retry_s = RETRY_FIRST_S

    @property
    def started(self) -> bool:
        """Return whether there is an engine, busy, idle or at rest."""
        return self._greeted

    @property
    def idle(self) -> bool:
        """Return whether it is ready for a text."""
        return self._greeted and not self._text

    def write(self, request: Request, limit_s: float) -> None:
        """Send a text; only when idle."""
        assert self.idle
        self._text, self._limit_s = msgspec.json.encode(request) + b"\n", limit_s
        if self._popen is not None:
            self._send(self._popen)

    def poll(self) -> Answer | None:
        """Return the result of the text, once there is one; start the process again if need be."""
        if self._popen is None:
            return None if self.idle else self._start_when_due()
        if (answer := self._read()) is not None:
            return self._take(answer)
        if (code := self._popen.poll()) is not None:
            how = f"signal {-code}" if code < 0 else f"exit code {code}"
            return self._lost(f"the speech engine died ({how})")
        if self.idle:
            if self._clock() - self._until > RESTS_AFTER_S:
                self._end()
        elif not self._clock() < self._until:
            doing = "its start" if self._starts else "this text"
            return self._lost(f"the speech engine did not come to an end with {doing}")
        return None

    def close(self) -> None:
        """End the process, and forget its text."""
        self._greeted, self._text = False, b""
        self._end()

    def _send(self, popen: "subprocess.Popen[bytes]") -> None:
        assert popen.stdin is not None
        self._until = self._clock() + self._limit_s
        with suppress(OSError):  # the process is dead, which `poll` notices
            os.write(popen.stdin.fileno(), self._text)

    def _end(self) -> None:
        popen, self._popen = self._popen, None
        if popen is not None:
            popen.kill()
            popen.wait()
            for pipe in (popen.stdin, popen.stdout):
                assert pipe is not None
                pipe.close()

    def _start_when_due(self) -> Answer | None:
        if self._clock() < self._retry_at:
            return None
        self._received, self._starts = b"", True
        try:
            self._popen = subprocess.Popen(
                dying_with_parent(self._program),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                bufsize=0,
                start_new_session=True,  # a scheduling group of its own, so that it does not delay our heartbeat
            )
        except OSError as err:
            return self._lost(f"the speech engine cannot be started: {err.strerror}")
        for pipe in (self._popen.stdin, self._popen.stdout):
            assert pipe is not None
            os.set_blocking(pipe.fileno(), False)  # one text fits into it
        self._until = self._clock() + START_S
        return None

    def _read(self) -> Answer | None:
        assert self._popen is not None
        assert self._popen.stdout is not None
        try:
            self._received += os.read(self._popen.stdout.fileno(), ANSWER_BYTES)
        except BlockingIOError:
            return None
        line, end, rest = self._received.partition(b"\n")
        if not end:
            return None
        self._received = rest
        try:
            return msgspec.json.decode(line, type=Answer)
        except UNREADABLE:
            return Answer(reason="the speech engine sent an unreadable answer")

    def _take(self, answer: Answer) -> Answer | None:
        assert self._popen is not None
        starts, self._starts = self._starts, False
        self._until = self._clock()
        if not starts:
            self._text = b""
            return answer
        if answer.reason:
            return self._lost(answer.reason)
        self._greeted, self.trouble, self._retry_s = True, "", RETRY_FIRST_S
        if self._text:
            self._send(self._popen)
        return None

    def _lost(self, why: str) -> Answer | None:
        """End the process.

        A crash on a text does not affect the next text; an engine that does not start is trouble.
        """
        asked = bool(self._text)
        self.close()
        if asked:
            return Answer(reason=why)
        self.trouble = why
        self._retry_at = self._clock() + self._retry_s
        self._retry_s = min(2 * self._retry_s, RETRY_MOST_S)
        return None
