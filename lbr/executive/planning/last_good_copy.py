"""Keeps a copy of rows that have run well for a while. A separate thread writes it, so that nothing waits for that."""

import os
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path

from lbr.database import copies
from lbr.errors import LbrError
from lbr.executive import threads

RUN_WELL_S = 5.0
AGAIN_AFTER_S = 60.0
LOWEST = 19
NOT_COPIED = "the last good rows are not copied"


class LastGoodCopy:
    """Copies the database. `trouble` receives why a copy failed, or an empty text, in the thread of `step`."""

    def __init__(self, path: Path, trouble: Callable[[str, str], None]) -> None:
        self._path = path
        self._trouble = trouble
        self._due: float | None = None
        self._thread: threading.Thread | None = None
        self._edited = False
        """True if the rows were edited before the last copy, which was therefore not made."""
        self._why = ""

    def touched(self, now: float) -> None:
        """Note an edit with which the robot runs well: it is copied after some seconds."""
        self._due = now + RUN_WELL_S

    def not_well(self) -> None:
        """Note that the rows in the database do not run: they are not copied."""
        self._due = None

    def step(self, now: float, digest: str) -> None:
        """Begin a copy when it is due, and report the result of the last one; `digest` is of the rows that run."""
        if self._thread is not None:
            if self._thread.is_alive():
                return
            self._thread = None
            if not self._edited:
                self._trouble(NOT_COPIED, self._why)
            if (self._edited or self._why) and self._due is None:
                self._due = now + AGAIN_AFTER_S
        if self._due is not None and now >= self._due:
            self._thread = threads.begin(partial(self._keep, digest), "keeper")
            self._due = None if self._thread is not None else now + AGAIN_AFTER_S
            if self._thread is None:
                self._trouble(NOT_COPIED, threads.NO_THREAD)

    def _keep(self, digest: str) -> None:
        with suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), LOWEST)
        self._edited, self._why = False, ""
        try:
            copies.keep(self._path, digest)
        except copies.EditedError:
            self._edited = True
        except LbrError as err:
            self._why = str(err)
