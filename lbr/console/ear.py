"""The watch on the operator's way to stop: nothing is kept moving for one who cannot stop it."""

import time
from collections.abc import Callable

BEAT_S = 0.1
FRESH_S = 0.5
"""Five beats: a busy machine loses two, and a lease of 0.3 s on top of it still ends within a second."""
ASK_S = 0.25
ANSWER_S = 1.0
"""Longer than a poor radio link takes for an answer, and as long as an operator may be gone unnoticed."""
STUCK_S = 0.4
"""A line of 9600 baud takes a piece of output in 0.3 s."""


class Ear:
    """The pulse of the thread that would take a stop: it calls `beat` ten times a second; `also` may know more."""

    def __init__(self, *, clock: Callable[[], float] = time.monotonic) -> None:
        self.also: Callable[[], str] = lambda: ""
        self._clock = clock
        self._beaten = clock()

    def beat(self) -> None:
        """Show that a stop would be heard now."""
        self._beaten = self._clock()

    def deaf(self, since: float) -> str:
        """Return why what has been held since then must not go on, nothing if it may."""
        if not self._clock() - max(self._beaten, since) <= FRESH_S:
            return f"the console was held up for {FRESH_S:g} s, and would not have heard a stop"
        return self.also()


class Contact:
    """Asks the terminal whether it is there, and knows since when it does not say so. One that never does is not asked
    again."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.on_answer: Callable[[], None] = lambda: None
        self._clock = clock
        self._answers = False
        self._asked: float | None = None
        self._asked_last = -ASK_S
        self._begun = False

    @property
    def open(self) -> bool:
        """Return whether an answer is still to come."""
        return self._asked is not None

    @property
    def awaited(self) -> bool:
        """Return whether an answer may well come in a moment."""
        return self._asked is not None and self._clock() - self._asked <= ANSWER_S

    def due(self, *, held: bool) -> bool:
        """Return whether to ask now: once at the beginning, and then while something is held."""
        if not self._begun:
            return True
        return self._answers and held and not self.open and self._clock() - self._asked_last >= ASK_S

    def asked(self) -> None:
        """Hear that the question went out."""
        self._begun = True
        self._asked = self._asked_last = self._clock()

    def answered(self) -> None:
        """Hear of an answer."""
        self._answers = True
        self._asked = None
        self.on_answer()

    def typed(self) -> None:
        """Hear of a line: a terminal that sends one is there, and is asked again if it still owes an answer."""
        if self.lost():
            self._asked = None

    def lost(self) -> str:
        """Return why the terminal is taken for gone, nothing if it is not."""
        if not self._answers or self._asked is None or self._clock() - self._asked <= ANSWER_S:
            return ""
        return f"the terminal has not answered for {ANSWER_S:g} s"
