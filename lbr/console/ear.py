"""The watch on the operator's means to stop: no motion goes on for an operator who cannot stop it."""

import time
from collections.abc import Callable

BEAT_S = 0.1
FRESH_S = 0.5
"""Five beats: a busy machine loses two, and together with a lease of 0.3 s, a motion still ends within a second."""
ASK_S = 0.25
ANSWER_S = 1.0
"""Longer than an answer needs over a poor radio link; an operator who is away is noticed after this time."""
STUCK_S = 0.4
"""A line of 9600 baud transmits a piece of output in 0.3 s."""


class Ear:
    """The pulse of the thread that receives stops: it calls `beat` ten times a second; `also` may add reasons."""

    def __init__(self, *, clock: Callable[[], float] = time.monotonic) -> None:
        self.also: Callable[[], str] = lambda: ""
        self._clock = clock
        self._beaten = clock()

    def beat(self) -> None:
        """Report that a stop would be received now."""
        self._beaten = self._clock()

    def deaf(self, since: float) -> str:
        """Return why a motion held since then must end, empty if it may go on."""
        if not self._clock() - max(self._beaten, since) <= FRESH_S:
            return f"the console was held up for {FRESH_S:g} s, and would have missed a stop"
        return self.also()


class Contact:
    """Asks the terminal for a sign of life, and tracks since when it owes one; never asks a silent terminal again."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.on_answer: Callable[[], None] = lambda: None
        self._clock = clock
        self._answers = False
        self._asked: float | None = None
        self._asked_last = -ASK_S
        self._begun = False

    @property
    def open(self) -> bool:
        """Return whether an answer is outstanding."""
        return self._asked is not None

    @property
    def awaited(self) -> bool:
        """Return whether an answer may come in a moment."""
        return self._asked is not None and self._clock() - self._asked <= ANSWER_S

    def due(self, *, held: bool) -> bool:
        """Return whether to ask now: once at the beginning, and then while a motion is held."""
        if not self._begun:
            return True
        return self._answers and held and not self.open and self._clock() - self._asked_last >= ASK_S

    def asked(self) -> None:
        """Note that the question was sent."""
        self._begun = True
        self._asked = self._asked_last = self._clock()

    def answered(self) -> None:
        """Note an answer."""
        self._answers = True
        self._asked = None
        self.on_answer()

    def typed(self) -> None:
        """Note a line: a terminal that sends one is present, so a missing answer is asked for again."""
        if self.lost():
            self._asked = None

    def lost(self) -> str:
        """Return why the terminal counts as gone, empty if it does not."""
        if not self._answers or self._asked is None or self._clock() - self._asked <= ANSWER_S:
            return ""
        return f"the terminal has not answered for {ANSWER_S:g} s"
