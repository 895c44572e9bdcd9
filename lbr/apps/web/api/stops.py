"""The stops received here, and which requests they overtake: a page's stop is read while its command still waits. Pure.

Between processes the dates of messages decide that. A request is dated when it is passed on. If a stop came while it
waited, it bears the date at which it was received.
"""

import re
import unicodedata
from math import inf, isfinite

from msgspec import Struct

ALL = ""
_STOP = re.compile(r"/*(s|stop|estop)(/.*)?")


class Waiting(Struct, frozen=True, kw_only=True):
    """The time that a request has waited here, and its date if that is not now."""

    waited_s: float = 0.0
    sent_s: float | None = None


AT_ONCE = Waiting()


class Stops:
    """The times of the last stop of each capability, and of all."""

    def __init__(self) -> None:
        self._at: dict[str, float] = {}

    def note(self, came_s: float, capability: str = ALL) -> None:
        """Note a stop; `capability` must exist on the robot."""
        self._at[capability] = max(came_s, self._at.get(capability, -inf))

    def overtook(self, came_s: float, capability: str = ALL) -> bool:
        """Return whether a stop came after a request; a request to all capabilities is overtaken by any stop."""
        last = max((at for name, at in self._at.items() if capability in {ALL, name} or name == ALL), default=-inf)
        return isfinite(came_s) and came_s <= last


def is_stop(line: str) -> bool:
    """Return whether a console line is a stop; the executive, which runs it, accepts more spellings."""
    return _STOP.fullmatch(unicodedata.normalize("NFKC", line).strip().lower()) is not None
