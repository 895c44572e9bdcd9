"""A line that asks for confirmation: yes sends it, anything else cancels it."""

import time
from collections.abc import Callable

from lbr.messages.system import ConsoleResult

VALID_S = 30.0
YES, NO = frozenset({"y", "yes"}), frozenset({"n", "no"})
QUESTION = "Do it? y/N"
LET_BE = "Nothing was done."


class Confirmation:
    """At most one open question; a late answer counts as a line of its own."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._line = ""
        self._until = 0.0

    @property
    def open(self) -> bool:
        """Return whether it waits for an answer."""
        return bool(self._line) and self._clock() < self._until

    def ask(self, result: ConsoleResult) -> None:
        """Keep the line that a yes will send."""
        self._line, self._until = result.confirm, self._clock() + VALID_S

    def answer(self, line: str) -> str | None:
        """Return the line to send: this one, the confirmed one, or None after a no."""
        agreed, waited = self._line, self.open
        self._line = ""
        said = line.strip().lower()
        if not waited or said not in YES | NO | {""}:
            return line
        return agreed if said in YES else None
