"""An overloaded machine: reported in one line when it begins, and once when it is over. Pure."""

import os

OVER_AFTER_S = 10.0
"""The time for other faults to disappear after the last process was starved of the processor."""


class Busy:
    """`on` from the first process that is starved until none has been for a while."""

    def __init__(self) -> None:
        self.on = False
        self._since = self._last = 0.0
        self._names: dict[str, float] = {}

    def starved(self, name: str, waited_s: float, now: float) -> str:
        """Note that a process is starved of the processor; return the report for people, empty if they have it."""
        self._last = now
        self._names[name] = max(waited_s, self._names.get(name, 0.0))
        if self.on:
            return ""
        self.on, self._since = True, now
        load, cores = os.getloadavg()[0], len(os.sched_getaffinity(0))
        said = f"'{name}' has waited {waited_s:.1f} s for the processor (load {load:.0f} on {cores} cores)"
        return f"this machine is too busy: {said}; nothing is ended for it, and what moves keeps its deadlines"

    def over(self, now: float) -> str:
        """Return the report for people once the overload is over, otherwise an empty text."""
        if not self.on or not now - self._last > OVER_AFTER_S:
            return ""
        worst = max(self._names, key=lambda name: self._names[name])
        text = f"this machine keeps up again, after {now - self._since:.0f} s in which {len(self._names)} were held up"
        said = f"{text}; '{worst}' the longest, {self._names[worst]:.1f} s"
        self.on, self._names = False, {}
        return said
