"""Motion that a program borrows: kept by the program itself, or within a `with` for a bounded time."""

import math
import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Protocol, Self

import msgspec

from lbr.bus import wire
from lbr.bus.session import FORKED, Session
from lbr.errors import BusError, InputError, LbrError
from lbr.leases.client import ANSWER_S, LeaseClient, LeaseTarget
from lbr.leases.over_session import OverSession
from lbr.messages.drive import GoalResult
from lbr.messages.unreadable import UNREADABLE

Message = dict[str, Any]
"""A message as JSON: the fields of its schema (`lbr topic`, docs/reference)."""

POLL_S = 0.005
RESULT_S = 0.5
KEEP_S = 0.02
"""The interval at which a thread checks a kept motion; a lease is renewed each 0.1 s."""
AT_MOST_S, LONGEST_S = 5.0, 30.0
RELEASED = "the program released it"
WHAT_THERE_IS = "'lbr topic list' names what there is"


class RefusalError(LbrError):
    """The robot refuses or ends the motion: `code` is one of docs/reference/codes.md, the text is for people."""

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code = code


def of_numbers(message: Message) -> Message:
    """Return fields unchanged; raise InputError for NaN or infinity, which JSON cannot hold."""
    for field, value in message.items():
        if isinstance(value, float) and not math.isfinite(value):
            raise InputError(f"{field}={value} is no number that can be sent")
    return dict(message)


class Lender(Protocol):
    """The connection over which a motion is borrowed: a connected robot."""

    source: str

    @property
    def why_unanswered(self) -> str:
        """Return why an existing command may not answer us; empty if nothing prevents it."""

    @property
    def session(self) -> Session:
        """Our session of the bus."""

    def key(self, name: str) -> str:
        """Return the complete key of a command."""


class Motion:
    """Borrowed motion: call `keep` ten times a second; a `with` releases it at its end."""

    def __init__(self, robot: Lender, key: str, first: Message) -> None:
        self.message = of_numbers(first)
        self._process = os.getpid()
        self._closed = False
        capability = key.partition("/")[0]
        ports = {"motion": robot.key(key), "halt": robot.key(f"{capability}/stop")}
        over = OverSession(robot.session, robot.source, ports)
        asked = LeaseTarget("motion", "halt", kind=capability, result_s=RESULT_S)
        self._results = wire.Subscription(robot.session, robot.key(f"{capability}/result"), depth=8)
        self._client = LeaseClient(over, asked, self.message)
        until = time.monotonic() + 2 * ANSWER_S
        while self._client.accepted is None and self._client.ended is None and time.monotonic() < until:
            time.sleep(POLL_S)
            self._client.step()
        if not self._client.holds:
            self._results.close()
            why = self._client.ended
            silent = f"'{key}' does not answer; {robot.why_unanswered or WHAT_THERE_IS}"
            if why is None:
                raise BusError(silent)
            raise RefusalError(why.code, silent if self._client.silent else why.text)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_exc: object) -> None:
        self.release()

    @property
    def done(self) -> bool:
        """Return whether its goal is reached: the angle, the distance, the key frames."""
        self._read_results()
        return self._client.good

    def keep(self, **change: Any) -> bool:
        """Go on, with changed fields if any; return False once it is done. Raise RefusalError if it has ended."""
        self.message.update(of_numbers(change))
        self._read_results()
        if self._client.ended is None:
            self._client.keep(self.message)
        elif not self._client.good:
            raise RefusalError(self._client.ended.code, self._client.ended.text)
        return not self._client.good

    def wait(self) -> None:
        """Keep it until it is done; raise RefusalError if it does not end as planned."""
        while self.keep():
            time.sleep(POLL_S)

    def release(self) -> None:
        """Stop it, if it is still ours; do nothing in a forked process."""
        if not self._ours():
            return
        asked = self._client.release(RELEASED)
        until = time.monotonic() + ANSWER_S
        while asked is not None and asked.answers() is None and time.monotonic() < until:
            time.sleep(POLL_S)
        if not self._closed:
            self._closed = True
            self._results.close()

    def _ours(self) -> bool:
        return os.getpid() == self._process

    def _read_results(self) -> None:
        if not self._ours():
            raise BusError(FORKED)
        for raw in self._results.take():
            with suppress(*UNREADABLE):
                self._client.hear(msgspec.json.decode(raw.payload, type=GoalResult))
        self._client.step()


class KeptMotion:
    """Motion that goes on within a `with`, for `at_most_s` at most; then it is released.

    A thread keeps it, so that the program may wait or compute meanwhile. It ends with this process: a program that is
    killed, frozen, or blocked in C code keeps nothing. `at_most_s` bounds one that waits for too long.
    """

    def __init__(self, begin: Callable[[], Motion], at_most_s: float) -> None:
        self.lost: LbrError | None = None
        self._begin = begin
        self._at_most_s = bounded(at_most_s)
        self._motion: Motion | None = None
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="kept motion", daemon=True)

    def __enter__(self) -> Self:
        self._motion = self._begin()
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *_exc: object) -> None:
        self._over.set()
        self._thread.join()
        if kind is None and self.lost is not None:
            raise self.lost

    @property
    def moving(self) -> bool:
        """Return whether the motion still goes on."""
        return self._thread.is_alive() and not self._over.is_set()

    def change(self, **change: Any) -> None:
        """Change these fields of the motion; raise RefusalError if it has ended."""
        if self._motion is None:
            raise InputError("this motion has not begun: it does within its `with`")
        with self._lock:
            self._motion.keep(**change)

    def wait(self, timeout_s: float | None = None) -> bool:
        """Wait for its end; return whether it has come. Raise RefusalError if it does not end as planned."""
        self._thread.join(timeout_s)
        if self.lost is not None:
            raise self.lost
        return not self._thread.is_alive()

    def _run(self) -> None:
        assert self._motion is not None
        until = time.monotonic() + self._at_most_s
        try:
            while time.monotonic() < until and self._goes_on(self._motion):
                if self._over.wait(KEEP_S):
                    break
        except LbrError as error:
            self.lost = error
        finally:
            with self._lock, suppress(BusError):  # the robot was disconnected meanwhile: the lease expires
                self._motion.release()

    def _goes_on(self, motion: Motion) -> bool:
        with self._lock:
            return motion.keep()


def bounded(at_most_s: float) -> float:
    """Return the time for which motion is kept; raise InputError unless it is a positive number of seconds."""
    if not (math.isfinite(at_most_s) and at_most_s > 0):
        raise InputError(f"at_most_s={at_most_s!r} is no number of seconds above 0")
    return at_most_s
