"""Two multiprocessing.JoinableQueue hops, the usual wiring of many robots of this size, for comparison."""

import multiprocessing
import time
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import Any


class TwoHops:
    """Parent to first process to second process, each hop a JoinableQueue; the second reports the arrival."""

    def __init__(self, first: "multiprocessing.JoinableQueue[Any]", arrived: Connection) -> None:
        self._first = first
        self._arrived = arrived

    def once(self, message: dict[str, Any]) -> float:
        """Send a message through; return the milliseconds until its arrival."""
        at_ns = time.monotonic_ns()
        self._first.put(message)
        return float(self._arrived.recv() - at_ns) * 1e-6


@contextmanager
def two_hops() -> Iterator[TwoHops]:
    """Start both processes, and end them."""
    context = multiprocessing.get_context("spawn")
    first, second = context.JoinableQueue(), context.JoinableQueue()
    here, there = context.Pipe(duplex=False)
    workers = [
        context.Process(target=_pass_on, args=(first, second), daemon=True),
        context.Process(target=_tell, args=(second, there), daemon=True),
    ]
    for worker in workers:
        worker.start()
    try:
        hops = TwoHops(first, here)
        hops.once({})  # both run once this has come through
        yield hops
    finally:
        first.put(None)
        for worker in workers:
            worker.join(5.0)


def _pass_on(source: "multiprocessing.JoinableQueue[Any]", target: "multiprocessing.JoinableQueue[Any]") -> None:
    while True:
        message = source.get()
        target.put(message)
        source.task_done()
        if message is None:
            return


def _tell(source: "multiprocessing.JoinableQueue[Any]", arrived: Connection) -> None:
    while (message := source.get()) is not None:
        arrived.send(time.monotonic_ns())
        source.task_done()
        del message
