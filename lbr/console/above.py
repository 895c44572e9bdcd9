"""Text above a prompt: whatever is printed, from whichever thread, appears above the input line and never inside it."""

import contextlib
import threading
from collections.abc import Callable, Iterator
from typing import IO, Any, cast

from prompt_toolkit.application import Application
from prompt_toolkit.output.vt100 import Vt100_Output

GATHER_S = 0.02  # what is printed within so long appears in one step


class Screen(Vt100_Output):
    """A terminal that is asked nothing: the prompt takes the rows that it needs, wherever the cursor is."""

    def get_rows_below_cursor_position(self) -> int:
        """Return the one row that there is for sure."""
        return 1


class Above:
    """Writes text above the prompt of an application; what comes before it runs or after its end is not lost."""

    def __init__(self, app: Application[Any]) -> None:
        self._app = app
        self._lock = threading.RLock()
        self._waiting: list[str] = []
        self._scheduled = False
        self._over = False

    def print(self, text: str) -> None:
        """Show whole lines, from any thread."""
        with self._lock:
            self._waiting.append(text + "\n")
            if self._over:
                self._write()
            elif not self._scheduled:
                self._schedule()

    def started(self) -> None:
        """Show what waits; to be called when the application begins to run."""
        with self._lock:
            self._schedule()

    def ended(self) -> None:
        """Show what waits, and from now on write at once; to be called when the application has ended."""
        with self._lock:
            self._over = True
            self._write()

    @contextlib.contextmanager
    def catching(self, show: Callable[[str], None]) -> Iterator[None]:
        """Hand the lines that others print to standard output and error meanwhile to `show`."""
        caught = cast("IO[str]", _Printed(show))
        with contextlib.redirect_stdout(caught), contextlib.redirect_stderr(caught):
            yield

    def _schedule(self) -> None:
        loop, context = self._app.loop, self._app.context
        if loop is None or context is None:
            return
        try:
            # The callback must see this application as the running one, whichever thread prints.
            copied = context.copy()
            loop.call_soon_threadsafe(lambda: loop.call_later(GATHER_S, self._show, context=copied), context=copied)
            self._scheduled = True
        except RuntimeError:  # it ends just now; `ended` shows the rest
            pass

    def _show(self) -> None:
        app = self._app
        with self._lock, contextlib.suppress(OSError):  # the terminal hung up; the prompt notices too
            self._scheduled = False
            if not self._waiting or app.is_done or self._over:
                return
            app.renderer.erase()
            self._write()
            app.renderer.render(app, app.layout)

    def _write(self) -> None:
        text, self._waiting = "".join(self._waiting), []
        with contextlib.suppress(OSError):
            self._app.output.write_raw(text.replace("\n", "\r\n"))
            self._app.output.flush()


class _Printed:
    """A file that hands on whole lines."""

    encoding = "utf-8"

    def __init__(self, show: Callable[[str], None]) -> None:
        self._show = show
        self._lock = threading.Lock()
        self._rest = ""

    def write(self, text: str) -> int:
        with self._lock:
            *lines, self._rest = (self._rest + text).split("\n")
        if lines:
            self._show("\n".join(lines))
        return len(text)

    def flush(self) -> None:
        """Wait for the end of the line."""

    def isatty(self) -> bool:
        return False
