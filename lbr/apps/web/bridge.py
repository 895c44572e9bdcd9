"""Runs coroutines of the server's thread in the capability's loop, and returns their results.

The loop resumes a coroutine once a round, and the coroutine then checks its own condition: no callbacks, and no other
thread. The only promise between a request and its answer is here.
"""

import asyncio
from collections import deque
from collections.abc import Callable, Coroutine, Generator
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from typing import Any, Generic, TypeVar

from lbr.apps.web.face import ANSWER_S, Refused
from lbr.capability.border import border

T = TypeVar("T")
MOST_WAITING = 256


class Promise(Future[T], Generic[T]):
    """A result of a later round of the loop; its receiver may have left meanwhile."""

    def keep(self, result: T) -> None:
        """Set the result, once; ignored if nobody waits for it any more."""
        with suppress(InvalidStateError):
            self.set_result(result)

    def refuse(self, err: BaseException) -> None:
        """Set the error that takes the place of a result."""
        with suppress(InvalidStateError):
            self.set_exception(err)


class _NextRound:
    def __await__(self) -> Generator[None, None, None]:
        yield


async def until(ready: Callable[[], bool]) -> None:
    """Wait, in the loop, for the round in which `ready` is true; it may be this one."""
    while not ready():
        await _NextRound()


class Bridge:
    """Runs coroutines in the loop. `call` is for the server's thread, all else for the loop's."""

    def __init__(self, wake: Callable[[], None], failed: Callable[[Exception], None]) -> None:
        self._wake = wake
        self._failed = failed
        self._inbox: deque[tuple[Coroutine[Any, Any, Any], Promise[Any]]] = deque()
        self._under_way: list[tuple[Coroutine[Any, Any, Any], Promise[Any]]] = []
        self._closed = ""

    async def call(self, work: Coroutine[Any, Any, T], *, timeout_s: float = ANSWER_S) -> T:
        """Run a coroutine in the loop, and return its result.

        Raise Refused (503) if the loop ends, is overloaded, or gives no result in time. A coroutine that has begun goes
        on even if nobody waits for it any more: its requests to the robot may have been done.
        """
        if self._closed or len(self._inbox) >= MOST_WAITING:
            work.close()
            raise Refused(503, self._closed or "too much is asked at once; try again", {"Retry-After": "1"})
        promise: Promise[T] = Promise()
        self._inbox.append((work, promise))
        self._wake()
        try:
            return await asyncio.wait_for(asyncio.wrap_future(promise), timeout_s)
        except TimeoutError:
            raise Refused(
                503, f"the robot did not answer within {timeout_s:g} s", {"Retry-After": "1"}, "timeout"
            ) from None

    def start(self, work: Coroutine[Any, Any, T]) -> Promise[T]:
        """Run a coroutine, from within the loop; the promise receives its result."""
        promise: Promise[T] = Promise()
        self._go_on(work, promise)
        return promise

    def serve(self) -> None:
        """Resume all coroutines under way, and begin those that wait."""
        under_way, self._under_way = self._under_way, []
        for work, promise in under_way:
            self._go_on(work, promise)
        while self._inbox:
            work, promise = self._inbox.popleft()
            if promise.cancelled():
                work.close()  # the client is gone
            else:
                self._go_on(work, promise)

    def open(self) -> None:
        """Accept calls again."""
        self._closed = ""

    def close(self, why: str) -> None:
        """Refuse all waiting and later calls."""
        self._closed = why
        for waiting in (self._inbox, self._under_way):
            while waiting:
                work, promise = waiting.pop()
                work.close()
                promise.refuse(Refused(503, why))

    def _go_on(self, work: Coroutine[Any, Any, Any], promise: Promise[Any]) -> None:
        def broken(err: Exception) -> None:
            self._failed(err)
            promise.refuse(err)

        try:
            with border(broken, StopIteration, Refused):  # a fault in one answer must not block the others
                work.send(None)
                self._under_way.append((work, promise))
        except StopIteration as done:
            promise.keep(done.value)
        except Refused as err:
            promise.refuse(err)
