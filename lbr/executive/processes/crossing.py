"""Finds out whether questions pass from one router to another that has called it.

The bus library takes up a broken link by itself, sometimes within a millisecond. If the called end has not let the old
link go by then, it forgets the new one. That link stands, and no question passes. Only asking shows it.
"""

import time
from collections.abc import Callable

from lbr.bus import keys, wire
from lbr.bus.links import Links
from lbr.bus.session import Session

LOOK_AFTER_S = 0.3
"""Routers report changes to one another 0.1 s later. Beside five loaded robots on two cores it took 0.5 s at most."""
ASKED_S = 0.5
BROKEN_AFTER = 4


def answer(router: Session, robot: str) -> wire.StaticReply:
    """Have a router answer for itself as long as it is open."""
    own_id = str(router.info.zid())
    return wire.StaticReply(router, keys.router(robot, own_id), lambda: own_id)


class Crossing:
    """Asks at `near` for the router with the id `far`, whenever a link between them has come or gone.

    `wake` is called when it may be time to look.
    """

    def __init__(self, near: Session, far: str, robot: str, wake: Callable[[], None]) -> None:
        self._near = near
        self._far = far
        self._key = keys.router(robot, far)
        self._unanswered = 0
        self._due: float | None = time.monotonic() + LOOK_AFTER_S
        self._links = Links(near, ("unixsock-stream",), wake)

    def due(self) -> float | None:
        """Return when to look, None while there is no reason to."""
        if any(one.session_id == self._far for one in self._links.take()):
            self._unanswered, self._due = 0, time.monotonic() + LOOK_AFTER_S
        return self._due

    def broken(self) -> bool:
        """Ask once, for at most ASKED_S; return whether so many questions had no answer that nothing will pass."""
        if wire.ask(self._near, self._key, None, source="executive", timeout_s=ASKED_S):
            self._unanswered, self._due = 0, None
        else:
            self._unanswered, self._due = self._unanswered + 1, time.monotonic() + ASKED_S
        return self._unanswered >= BROKEN_AFTER

    @property
    def passes(self) -> bool:
        """Return whether the last question had its answer: routes are known to both ends then."""
        return self._due is None

    def close(self) -> None:
        """Look no more."""
        self._due = None
        self._links.close()
