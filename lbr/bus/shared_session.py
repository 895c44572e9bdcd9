"""One session for several who share a process: each has a part of it, as if it were its own.

A message of one of them reaches the others within the process, without a router; messages of others reach all of them
once.
"""

import threading
import time
from collections.abc import Callable
from typing import Any, cast

import zenoh

from lbr.bus.session import Session

TRIES, TRY_AGAIN_S = 50, 0.001
"""Another thread looks at what is declared for microseconds."""
LOOK_AFTER = 64
"""So many more declared: time to forget what was taken back meanwhile."""


class SharedSession:
    """Closed with its last part, after `closed` was called; who opens or enters one holds `lock`."""

    def __init__(self, opened: Session, closed: Callable[[], object], lock: threading.Lock) -> None:
        self._session = opened
        self._closed = closed
        self._lock = lock
        self._parts = 0

    def enter(self) -> Session:
        """Return a part of it."""
        self._parts += 1
        return cast("Session", Part(self._session, self._leave))

    def _leave(self) -> None:
        with self._lock:
            self._parts -= 1
            last = not self._parts
            if last:
                self._closed()
        if last:
            self._session.close()


class Part:
    """The part of a session that one of several uses; closing it withdraws its declarations, and nothing else."""

    def __init__(self, session: Session, left: Callable[[], None]) -> None:
        self._session = session
        self._leave = left
        self._declared: list[Any] = []
        self._look_at = LOOK_AFTER
        self._open = True
        self.get, self.put, self.info = session.get, session.put, session.info

    def declare_publisher(self, *args: Any, **more: Any) -> Any:
        """Declare one, to be taken back at the end."""
        return self._keep(self._session.declare_publisher(*args, **more))

    def declare_subscriber(self, *args: Any, **more: Any) -> Any:
        """Declare one, to be taken back at the end."""
        return self._keep(self._session.declare_subscriber(*args, **more))

    def declare_queryable(self, *args: Any, **more: Any) -> Any:
        """Declare one, to be taken back at the end."""
        return self._keep(self._session.declare_queryable(*args, **more))

    def liveliness(self) -> "PartOfLiveliness":
        """Return what shows and watches presence."""
        return PartOfLiveliness(self._session.liveliness(), self._keep)

    def close(self) -> None:
        """Take back all that was declared; the last part closes the session."""
        if not self._open:
            return
        self._open = False
        for one in self._declared:
            _take_back(one)
        self._declared.clear()
        self._leave()

    def _keep(self, declared: Any) -> Any:
        if len(self._declared) >= self._look_at:
            self._declared = [one for one in self._declared if _stands(one)]
            self._look_at = len(self._declared) + LOOK_AFTER
        self._declared.append(declared)
        return declared


class PartOfLiveliness:
    """The liveliness of a part."""

    def __init__(self, liveliness: zenoh.Liveliness, keep: Callable[[Any], Any]) -> None:
        self._liveliness = liveliness
        self._keep = keep

    def declare_token(self, *args: Any, **more: Any) -> Any:
        """Declare one, to be taken back at the end."""
        return self._keep(self._liveliness.declare_token(*args, **more))

    def declare_subscriber(self, *args: Any, **more: Any) -> Any:
        """Declare one, to be taken back at the end."""
        return self._keep(self._liveliness.declare_subscriber(*args, **more))


def _take_back(declared: Any) -> None:
    """Undeclare, once no other thread looks at it any more."""
    for _ in range(TRIES):
        try:
            declared.undeclare()
        except RuntimeError:  # "Already borrowed"
            time.sleep(TRY_AGAIN_S)
        except zenoh.ZError:  # it was taken back already
            return
        else:
            return


def _stands(declared: Any) -> bool:
    """Return whether it was not taken back; what has no key, or is looked at by another thread, is taken to stand."""
    try:
        return getattr(declared, "key_expr", None) is not False
    except RuntimeError:
        return True
    except zenoh.ZError:
        return False
