"""Between the server's thread and the capability's loop: a coroutine goes over there, and what it returns comes back.

The one promise between a request and its answer is here. In the loop a coroutine is resumed once a round, and looks for
itself whether what it waits for is there: no callbacks, and no other thread.
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
    """A result that comes in a later round of the loop; who waits for it may have left meanwhile."""

    def keep(self, result: T) -> None:
        """Give the result, once; ignored if it is no longer waited for."""
        with suppress(InvalidStateError):
            self.set_result(result)

    def refuse(self, err: BaseException) -> None:
        """Say why there will be none."""
        with suppress(InvalidStateError):
            self.set_exception(err)


class _NextRound:
    def __await__(self) -> Generator[None, None, None]:
        yield


async def until(ready: Callable[[], bool]) -> None:
    """Wait, in the loop, for the round in which something is so; it may be this one."""
    while not ready():
        await _NextRound()


class Bridge:
    """`call` is for the server's thread, all else for the loop's."""

    def __init__(self, wake: Callable[[], None], failed: Callable[[Exception], None]) -> None:
        self._wake = wake
        self._failed = failed
        self._inbox: deque[tuple[Coroutine[Any, Any, Any], Promise[Any]]] = deque()
        self._under_way: list[tuple[Coroutine[Any, Any, Any], Promise[Any]]] = []
        self._closed = ""

    async def call(self, work: Coroutine[Any, Any, T], *, timeout_s: float = ANSWER_S) -> T:
        """Have a coroutine run in the loop, and return what it returns.

        Refused (503) if the loop ends, has too much to do, or nothing came of it in time. An act that has begun goes on
        also if it is no longer waited for: its requests to the robot may have been done.
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
        """Run a coroutine, from within the loop; the promise says what became of it."""
        promise: Promise[T] = Promise()
        self._go_on(work, promise)
        return promise

    def serve(self) -> None:
        """Go on with all that is under way, and begin what waits."""
        under_way, self._under_way = self._under_way, []
        for work, promise in under_way:
            self._go_on(work, promise)
        while self._inbox:
            work, promise = self._inbox.popleft()
            if promise.cancelled():
                work.close()  # the asker is gone
            else:
                self._go_on(work, promise)

    def open(self) -> None:
        """Take what comes again."""
        self._closed = ""

    def close(self, why: str) -> None:
        """Refuse what waits, and all that comes."""
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
            with border(broken, StopIteration, Refused):  # a fault in one answer must not silence the others
                work.send(None)
                self._under_way.append((work, promise))
        except StopIteration as done:
            promise.keep(done.value)
        except Refused as err:
            promise.refuse(err)
