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
"""A message as JSON has it: the fields of its schema (`lbr topic`, docs/reference)."""

POLL_S = 0.005
RESULT_S = 0.5
KEEP_S = 0.02
"""The pace at which the keeper of a motion looks at it; a lease is renewed each 0.1 s."""
AT_MOST_S, LONGEST_S = 5.0, 30.0
RELEASED = "the program released it"
WHAT_THERE_IS = "'lbr topic list' names what there is"


class RefusalError(LbrError):
    """The robot refuses, or ends the motion: `code` is one of docs/reference/codes.md, the text is for people."""

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code = code


def of_numbers(message: Message) -> Message:
    """Return fields of a message as they are; InputError names one that is NaN or infinite, which JSON has no word
    for."""
    for field, value in message.items():
        if isinstance(value, float) and not math.isfinite(value):
            raise InputError(f"{field}={value} is no number that can be sent")
    return dict(message)


class Lender(Protocol):
    """The way over which a motion is borrowed: a connected robot."""

    source: str

    @property
    def why_unanswered(self) -> str:
        """Return why a command that is there may not answer us; empty where nothing keeps us from it."""

    @property
    def session(self) -> Session:
        """Our session of the bus."""

    def key(self, name: str) -> str:
        """Return the whole key of a command."""


class Motion:
    """Motion that is borrowed: `keep` it ten times a second; a `with` releases it at its end."""

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
        """Return whether what it was to do is done: the angle, the distance, the key frames."""
        self._read_results()
        return self._client.good

    def keep(self, **change: Any) -> bool:
        """Go on, with fields changed if any; False once it is done. Raise RefusalError when it goes on no longer."""
        self.message.update(of_numbers(change))
        self._read_results()
        if self._client.ended is None:
            self._client.keep(self.message)
        elif not self._client.good:
            raise RefusalError(self._client.ended.code, self._client.ended.text)
        return not self._client.good

    def wait(self) -> None:
        """Keep it until it is done; raise RefusalError if it ends otherwise."""
        while self.keep():
            time.sleep(POLL_S)

    def release(self) -> None:
        """Stop it, if it is still ours; it is not in a process that was forked since."""
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

    A thread keeps it, so that the program may wait or compute meanwhile. It is a thread of this process: a program that
    is killed, frozen, or held up in C code keeps nothing. One that only waits for too long is bounded by `at_most_s`.
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
        """Return whether it still goes on."""
        return self._thread.is_alive() and not self._over.is_set()

    def change(self, **change: Any) -> None:
        """Go on with these fields changed; raise RefusalError if it goes on no longer."""
        if self._motion is None:
            raise InputError("this motion has not begun: it does within its `with`")
        with self._lock:
            self._motion.keep(**change)

    def wait(self, timeout_s: float | None = None) -> bool:
        """Wait for its end; say whether it has come. Raise RefusalError if it is not the end that it was to have."""
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
            with self._lock, suppress(BusError):  # the robot was disconnected from meanwhile: it lapses
                self._motion.release()

    def _goes_on(self, motion: Motion) -> bool:
        with self._lock:
            return motion.keep()


def bounded(at_most_s: float) -> float:
    """Return for how long something is kept moving; InputError if that is no positive number of seconds."""
    if not (math.isfinite(at_most_s) and at_most_s > 0):
        raise InputError(f"at_most_s={at_most_s!r} is no number of seconds above 0")
    return at_most_s
