"""Which events a console tells its operator: not those that its own lines have told already."""

import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator

from lbr.messages.system import Event

TOLD_S = 3.0
FOR_THE_RECORD = frozenset({"holder"})
MOVERS = frozenset({"drive", "joints", "motions"})
"""How an own motion of theirs ended is told by whoever held it."""


class News:
    """Sifts events by what `source` said and was answered within the last seconds; from any thread."""

    def __init__(self, source: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._own = f"{source}: "
        self._clock = clock
        self._said: deque[tuple[float, str]] = deque(maxlen=64)
        self._answers: deque[tuple[float, str]] = deque(maxlen=64)
        self._told: dict[str, tuple[float, str]] = {}

    def said(self, line: str) -> None:
        """Hear of a line before it is answered."""
        self._said.append((self._clock(), line))

    def answered(self, text: str) -> None:
        """Hear of what a line was answered."""
        self._answers.append((self._clock(), text))

    def sifted(self, events: Iterable[Event]) -> list[Event]:
        """Return the events that are news."""
        return [event for event in events if self._is_news(event)]

    def _is_news(self, event: Event) -> bool:
        own = event.text.startswith(self._own)
        if event.kind in FOR_THE_RECORD or (own and (event.subject in MOVERS or event.kind == "python")):
            return False
        text = event.text.removeprefix(self._own)
        by, _, told = event.text.partition(": ")
        if event.subject in MOVERS and by in MOVERS:
            if event.level == "info":
                return False  # one that moves for somebody by another tells it itself
            text = told
        if event.kind == "external" and any(text.startswith(f"'{line.split()[0]}'") for line in self._of(self._said)):
            return False
        if any(answer.startswith(text) for answer in self._of(self._answers)):
            return False
        now = self._clock()
        at, last = self._told.get(event.subject, (now, ""))
        self._told[event.subject] = now, event.text
        return event.text != last or now - at > TOLD_S

    def _of(self, remembered: deque[tuple[float, str]]) -> Iterator[str]:
        since = self._clock() - TOLD_S
        return (text for at, text in list(remembered) if at >= since and text.strip())
