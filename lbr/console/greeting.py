"""The start on the robot's own console: a few lines once all parts run, and until then only problems."""

from collections.abc import Callable

from lbr.messages.system import Event, Status

READY, NOT_READY = "ready", "not_ready"
"""The executive's events on which the greeting has details."""


class Greeting:
    """Chooses the events that are shown, and the time of the greeting.

    The greeting is due once the robot is ready, and before that at each report that it is not. `text` makes the
    greeting. `verbose` also shows the events of the start.
    """

    def __init__(self, text: Callable[[], str], *, verbose: bool) -> None:
        self.text = text
        self._verbose = verbose
        self._ready = False
        self._due = False

    def shows(self, event: Event) -> bool:
        """Return whether an event is shown; during the start, the greeting reports the degraded parts."""
        if event.subject == "executive" and event.kind in {READY, NOT_READY}:
            self._due = event.kind == NOT_READY
            return self._verbose
        return self._ready or self._verbose or (event.level != "info" and event.kind != "degraded")

    def is_due(self, status: Status | None) -> bool:
        """Return whether to show the greeting now; after that, again only with news."""
        due = self._due
        if status is not None and status.ready and not self._ready:
            self._ready = due = True
        self._due = False
        return due
