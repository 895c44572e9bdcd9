"""Chooses the events for a console's operator, without those that answers to its own lines have shown already."""

import time
from collections import deque
from collections.abc import Callable, Iterable

from lbr.messages.system import ConsoleResult, Event

TOLD_S = 3.0
FOR_THE_RECORD = frozenset({"holder"})
OWN_DEEDS = frozenset({"python", "external", "pair", "edit"})
"""The events of an operator's own line, whose answer contains them."""
MOVERS = frozenset({"drive", "joints", "motions"})
"""The program that holds their motion reports its end."""


class EventFilter:
    """Filters events by their sender, and by the answers that `source` got within the last seconds; for any thread."""

    def __init__(self, source: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._source = source
        self._clock = clock
        self._answers: deque[tuple[float, str]] = deque(maxlen=64)
        self._told: dict[str, tuple[float, str]] = {}

    def answered(self, result: ConsoleResult) -> None:
        """Note the answer to a line."""
        self._answers.append((self._clock(), result.reason_code))

    def sifted(self, events: Iterable[Event]) -> list[Event]:
        """Return the events that are news."""
        return [event for event in events if self._is_news(event)]

    def _is_news(self, event: Event) -> bool:
        own = event.about == self._source
        if event.kind in FOR_THE_RECORD or (own and (event.subject in MOVERS or event.kind in OWN_DEEDS)):
            return False
        relayed = event.subject in MOVERS and event.about in MOVERS
        if relayed and event.level == "info":
            return False  # a mover that moves through another one reports it itself
        if (own or relayed) and event.code in self._answered():
            return False
        now = self._clock()
        at, last = self._told.get(event.subject, (now, ""))
        self._told[event.subject] = now, event.text
        return event.text != last or now - at > TOLD_S

    def _answered(self) -> set[str]:
        """Return the codes of the answers of the last seconds."""
        since = self._clock() - TOLD_S
        return {code for at, code in list(self._answers) if at >= since}
