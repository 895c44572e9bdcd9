"""Kinds for a running robot. A separate thread tries the user's own files, so that they do not delay the robot."""

import threading
from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path

from lbr.capability import registry
from lbr.capability.kind import Kind, KindError
from lbr.executive import threads


class KindLoader:
    """The kinds of a home; to be used from one thread."""

    def __init__(self, home: Path) -> None:
        self._home = home
        self._known: dict[str, tuple[str, Kind | KindError]] = {}
        self._thread: threading.Thread | None = None

    def marks(self, names: Iterable[str]) -> dict[str, str]:
        """Return a mark for each kind that changes with its file; empty for an installed kind."""
        return {name: registry.mark(name, self._home) for name in sorted(set(names))}

    def try_now(self, marks: Mapping[str, str]) -> None:
        """Load the kinds of files; it may take some seconds."""
        for name, mark in marks.items():
            if mark:
                self._known[name] = mark, self._kind_of(name)

    def ready(self, marks: Mapping[str, str]) -> bool:
        """Return whether all of them are known in their present state; load the others on the separate thread."""
        new = {name: mark for name, mark in marks.items() if mark and self._known.get(name, ("",))[0] != mark}
        if new and (self._thread is None or not self._thread.is_alive()):
            self._thread = threads.begin(partial(self.try_now, new), "kinds")
        return not new

    def find(self, name: str, home: Path) -> Kind:
        """Return a kind that is ready; KindError if it is not."""
        _, known = self._known.get(name) or ("", None)
        if known is None or not registry.mark(name, home):
            return registry.find(name, home)
        if isinstance(known, KindError):
            raise known
        return known

    def forget_faults(self) -> None:
        """Try unusable kinds again at the next change: whatever they lacked may be installed by then."""
        self._known = {name: one for name, one in self._known.items() if isinstance(one[1], Kind)}

    def _kind_of(self, name: str) -> Kind | KindError:
        try:
            return registry.find(name, self._home)
        except KindError as err:
            return err
        except Exception as err:  # noqa: BLE001 - the thread's last frame: the rows are not to wait for ever
            return KindError(f"kind '{name}' cannot be loaded: {type(err).__name__}: {err}")
