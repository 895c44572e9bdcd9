"""The executive's main thread: calls from other threads, and its wake-ups."""

import contextlib
import os
import queue
import select
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import CancelledError, Future
from concurrent.futures import TimeoutError as FutureTimeout
from typing import Any, TypeVar

from lbr.errors import LbrError
from lbr.executive.services import Service

T = TypeVar("T")
ANSWER_LIMIT_S = 5.0


class MainThread(Service):
    """Runs what other threads hand over, in order, on the thread that made it."""

    def __init__(self) -> None:
        self._ident = threading.get_ident()
        self._calls: queue.SimpleQueue[tuple[Callable[[], Any], Future[Any]]] = queue.SimpleQueue()
        self._read, self.wake_fd = os.pipe()
        os.set_blocking(self._read, False)
        os.set_blocking(self.wake_fd, False)

    def call(self, do: Callable[[], T]) -> T:
        """Run `do` there and return its result, or raise its exception; LbrError if it cannot begin in time."""
        if threading.get_ident() == self._ident:
            return do()
        future: Future[T] = Future()
        self._calls.put((do, future))
        self.wake()
        try:
            return future.result(timeout=ANSWER_LIMIT_S)
        except FutureTimeout:
            if not future.cancel():  # it has begun, or raised this itself
                return future.result()
        except CancelledError:
            pass
        raise LbrError("the executive is busy or ends; try again")

    def post(self, do: Callable[[], object]) -> None:
        """Run `do` there, soon, and return at once."""
        self._calls.put((do, Future()))
        self.wake()

    def wake(self) -> None:
        """Wake it from its wait; may be called from any thread."""
        with contextlib.suppress(BlockingIOError):
            os.write(self.wake_fd, b"w")

    def wait(self, timeout_s: float, fds: Iterable[int]) -> None:
        """Wait for a wake-up or news on one of `fds`, then run the calls of other threads."""
        poll = select.poll()
        for fd in (self._read, *fds):
            poll.register(fd, select.POLLIN)
        poll.poll(timeout_s * 1000)
        with contextlib.suppress(BlockingIOError):
            while len(os.read(self._read, 4096)) == 4096:
                pass
        self.run_calls()

    def run_calls(self) -> None:
        """Run the calls of other threads."""
        while True:
            try:
                do, future = self._calls.get_nowait()
            except queue.Empty:
                return
            if not future.set_running_or_notify_cancel():
                continue
            try:
                future.set_result(do())
            except Exception as err:  # noqa: BLE001 - it belongs to the caller
                future.set_exception(err)

    def close(self) -> None:
        """Refuse calls that have not begun yet."""
        while True:
            try:
                self._calls.get_nowait()[1].cancel()
            except queue.Empty:
                return
