"""A bounded queue of messages: when it is full the oldest is dropped, but never a stop for another message."""

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class Inbox(Generic[T]):
    """One thread fills it and another reads it, in order of arrival; `is_stop` must never raise."""

    def __init__(self, most: int, is_stop: Callable[[T], bool]) -> None:
        self._most = most
        self._is_stop = is_stop
        self._lock = threading.Lock()
        self._waiting: list[tuple[T, bool]] = []

    def put(self, message: T) -> None:
        """Add a message."""
        stops = self._is_stop(message)
        with self._lock:
            if len(self._waiting) >= self._most:
                oldest = next((at for at, (_, stops_too) in enumerate(self._waiting) if not stops_too), None)
                if oldest is None and not stops:
                    return
                del self._waiting[oldest or 0]
            self._waiting.append((message, stops))

    def take(self) -> list[T]:
        """Return and remove all messages."""
        with self._lock:
            found, self._waiting = self._waiting, []
        return [message for message, _ in found]

    def clear(self) -> None:
        """Remove all messages."""
        self.take()
