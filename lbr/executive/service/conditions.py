"""What hinders the executive besides bad rows: told once when it begins and once when it is over, in the same words."""

from collections.abc import Callable


class Conditions:
    """What hinders the executive now. `happened(kind, subject, text, level)` hears every change; only for the
    executive's own thread."""

    def __init__(self, happened: Callable[[str, str, str, str], None]) -> None:
        self._happened = happened
        self._now: dict[str, str] = {}

    @property
    def current(self) -> tuple[str, ...]:
        """Return what is wrong at this moment."""
        return tuple(self._now.values())

    def tell(self, what: str, why: str) -> None:
        """Say why `what` cannot be done now; an empty `why` says that it can."""
        if why:
            text = f"{what}: {why}"
            if self._now.get(what) != text:
                self._now[what] = text
                self._happened("trouble", "executive", text, "error")
        elif self._now.pop(what, ""):
            self._happened("trouble_over", "executive", f"{what}: no longer so", "info")
