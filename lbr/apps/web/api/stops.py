"""Knows which requests a stop has overtaken here: a page's own stop is read while its command still waits. Pure.

Between processes the dates of messages tell that. A request is dated when it is passed on, so one that came before a
stop, and is passed on after it, bears the date at which it came.
"""

import re
import unicodedata
from math import inf, isfinite

from msgspec import Struct

ALL = ""
_STOP = re.compile(r"/*(s|stop|estop)(/.*)?")


class Waiting(Struct, frozen=True, kw_only=True):
    """For how long a request has waited here, and when it was said, if that is not now."""

    waited_s: float = 0.0
    sent_s: float | None = None


AT_ONCE = Waiting()


class Stops:
    """When the last stop of each capability, and of all, came here."""

    def __init__(self) -> None:
        self._at: dict[str, float] = {}

    def note(self, came_s: float, capability: str = ALL) -> None:
        """Take note of a stop; `capability` is one that there is."""
        self._at[capability] = max(came_s, self._at.get(capability, -inf))

    def overtook(self, came_s: float, capability: str = ALL) -> bool:
        """Say whether a stop came after a request did; what asks more than one capability is overtaken by any stop."""
        last = max((at for name, at in self._at.items() if capability in {ALL, name} or name == ALL), default=-inf)
        return isfinite(came_s) and came_s <= last


def is_stop(line: str) -> bool:
    """Return whether a console line stops; the executive, which carries it out, knows more ways to write it."""
    return _STOP.fullmatch(unicodedata.normalize("NFKC", line).strip().lower()) is not None
