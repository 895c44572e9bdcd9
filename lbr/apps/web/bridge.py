"""Between the server's thread and the capability's loop: work goes over there, and its result comes back."""

import asyncio
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from typing import Any, Generic, TypeVar

from lbr.apps.web.face import Refused
from lbr.capability.context import Asked

T = TypeVar("T")
MOST_WAITING = 256
ANSWER_S = 2.0


class Promise(Future[T], Generic[T]):
    """A result that comes in a later round of the loop; who waits for it may have left meanwhile."""

    def keep(self, result: T) -> None:
        """Give the result, once; ignored if nobody waits any more."""
        with suppress(InvalidStateError):
            self.set_result(result)

    def refuse(self, err: BaseException) -> None:
        """Say why there will be none."""
        with suppress(InvalidStateError):
            self.set_exception(err)


class Bridge:
    """`call` is for the server's thread, all else for the loop's."""

    def __init__(self, wake: Callable[[], None], failed: Callable[[Exception], None]) -> None:
        self._wake = wake
        self._failed = failed
        self._inbox: deque[tuple[Callable[[], Any], Promise[Any]]] = deque()
        self._under_way: list[tuple[Asked, Promise[Any]]] = []
        self._closed = ""

    async def call(self, work: Callable[[], Any], *, timeout_s: float = ANSWER_S) -> Any:
        """Have the loop run `work`, and return what it returns; if that is a Promise, what it becomes.

        Refused (503) if the loop ends, has too much to do, or nothing came of it in time.
        """
        if self._closed or len(self._inbox) >= MOST_WAITING:
            raise Refused(503, self._closed or "too much is asked at once; try again", {"Retry-After": "1"})
        promise: Promise[Any] = Promise()
        self._inbox.append((work, promise))
        self._wake()
        try:
            return await asyncio.wait_for(asyncio.wrap_future(promise), timeout_s)
        except TimeoutError:
            raise Refused(503, f"the robot did not answer within {timeout_s:g} s", {"Retry-After": "1"}) from None

    def follow(self, asked: Asked) -> "Promise[dict[str, Any]]":
        """Return the promise of a question's answers, by who gave them."""
        promise: Promise[dict[str, Any]] = Promise()
        self._under_way.append((asked, promise))
        return promise

    def serve(self) -> None:
        """Do what waits, and deliver the answers that have come."""
        while self._inbox:
            self._run(*self._inbox.popleft())
        under_way, self._under_way = self._under_way, []
        for asked, promise in under_way:
            answers = asked.answers()
            if answers is None:
                self._under_way.append((asked, promise))
            else:
                promise.keep(dict(answers))

    def open(self) -> None:
        """Take what comes again."""
        self._closed = ""

    def close(self, why: str) -> None:
        """Refuse what waits, and all that comes."""
        self._closed = why
        while self._inbox:
            self._inbox.popleft()[1].refuse(Refused(503, why))
        while self._under_way:
            self._under_way.pop()[1].refuse(Refused(503, why))

    def _run(self, work: Callable[[], Any], promise: Promise[Any]) -> None:
        if promise.cancelled():
            return  # whoever asked is gone
        try:
            found = work()
        except Refused as err:
            promise.refuse(err)
        except Exception as err:  # noqa: BLE001 - a fault in one answer must not silence the others
            self._failed(err)
            promise.refuse(err)
        else:
            if isinstance(found, Future):
                found.add_done_callback(lambda done: _pass_on(done, promise))
            else:
                promise.keep(found)


def _pass_on(done: "Future[Any]", promise: Promise[Any]) -> None:
    if done.cancelled():
        promise.refuse(Refused(503, "it was given up"))
    elif (err := done.exception()) is not None:
        promise.refuse(err)
    else:
        promise.keep(done.result())
