"""Text above a prompt: the output of all threads appears above the input line and never inside it.

Nothing here waits for the terminal. While the terminal accepts no output, the prompt is not drawn, and text waits in a
bounded store.
"""

import contextlib
import threading
from collections import deque
from collections.abc import Callable, Iterator
from typing import IO, Any, TextIO, cast

from prompt_toolkit.application import Application
from prompt_toolkit.data_structures import Size
from prompt_toolkit.layout import Layout
from prompt_toolkit.output.vt100 import Vt100_Output
from prompt_toolkit.renderer import Renderer

from lbr.console.outlet import Outlet, Stream, left_out

GATHER_S = 0.02  # output within this time appears in one step
AGAIN_S = 0.05
AHEAD_BYTES = 4_000
"""With so many unwritten bytes, nothing more is drawn: a Linux terminal buffers as many."""
STEP_CHARS = 16_000
KEPT_CHARS = 1_000_000


class Screen(Vt100_Output):
    """A terminal that no writer waits for. The prompt takes the rows that it needs, wherever the cursor is."""

    outlet: Outlet

    @classmethod
    def on(cls, stdout: TextIO, term: str | None = None) -> "Screen":
        """Return the screen behind a text file."""
        sizes = Vt100_Output.from_pty(stdout, term=term)
        outlet = Outlet()
        screen = cls(cast("TextIO", Stream(outlet, stdout.fileno())), sizes.get_size, term=term)
        screen.outlet = outlet
        return screen

    @property
    def free(self) -> bool:
        """Return whether the terminal accepts output."""
        return self.outlet.waiting < AHEAD_BYTES

    def get_rows_below_cursor_position(self) -> int:
        """Return one, the only number of rows that is certain."""
        return 1


class PatientRenderer(Renderer):
    """Draws only while the screen accepts output, so that the terminal shows what was drawn last."""

    def __init__(self, plain: Renderer, screen: Screen) -> None:
        super().__init__(plain.style, screen, plain.full_screen, plain.mouse_support, plain.cpr_not_supported_callback)
        self._screen = screen
        self.late = False

    def render(self, app: Application[object], layout: Layout, is_done: bool = False) -> None:
        """Draw, now or when there is room."""
        self.late = not (is_done or self._screen.free)
        if not self.late:
            super().render(app, layout, is_done)


class PromptOutput:
    """Writes text above the prompt of an application; text before its start or after its end is kept."""

    def __init__(self, app: Application[Any], screen: Screen) -> None:
        self._app = app
        self._screen = screen
        self._renderer = app.renderer = PatientRenderer(app.renderer, screen)
        self._lock = threading.RLock()
        self._waiting: deque[str] = deque()
        self._size = 0
        self._left_out = 0
        self._scheduled = False
        self._over = False
        screen.outlet.taken = self._draw_late

    @property
    def size(self) -> Size:
        """Return the size of the terminal."""
        return self._screen.get_size()

    def print(self, text: str) -> None:
        """Show whole lines, from any thread; if the terminal does not accept them, the oldest are dropped."""
        with self._lock:
            for line in text.split("\n"):
                self._waiting.append(line + "\n")
                self._size += len(line) + 1
            while self._size > KEPT_CHARS:
                self._size -= len(self._waiting.popleft())
                self._left_out += 1
            if self._over:
                self._write(self._size)
            elif not self._scheduled:
                self._schedule(GATHER_S)

    def started(self) -> None:
        """Show the waiting text; to be called when the application begins to run."""
        with self._lock:
            self._schedule(GATHER_S)

    def ended(self) -> None:
        """Show the waiting text, and from now on write at once; to be called when the application has ended."""
        with self._lock:
            self._over = True
            self._write(self._size)

    @contextlib.contextmanager
    def catching(self, show: Callable[[str], None]) -> Iterator[None]:
        """Pass the lines that others print to standard output and error meanwhile to `show`."""
        caught = cast("IO[str]", _Printed(show))
        with contextlib.redirect_stdout(caught), contextlib.redirect_stderr(caught):
            yield

    def _schedule(self, after_s: float) -> None:
        loop, context = self._app.loop, self._app.context
        if loop is None or context is None:
            return
        try:
            # The callback must find this application as the running one, whichever thread prints.
            copied = context.copy()
            loop.call_soon_threadsafe(lambda: loop.call_later(after_s, self._show, context=copied), context=copied)
            self._scheduled = True
        except RuntimeError:  # it ends just now; `ended` shows the rest
            pass

    def _draw_late(self) -> None:
        """Draw the part that was left out, now that the terminal has room."""
        if self._renderer.late and self._screen.free:
            self._app.invalidate()

    def _show(self) -> None:
        app = self._app
        with self._lock:
            self._scheduled = False
            if not self._waiting or app.is_done or self._over:
                return
            if not self._screen.free:
                self._schedule(AGAIN_S)
                return
            app.renderer.erase()
            self._write(STEP_CHARS)
            app.renderer.render(app, app.layout)
            if self._waiting:
                self._schedule(0.0)

    def _write(self, most: int) -> None:
        notice = f"{left_out(self._left_out)}\r\n" if self._left_out else ""
        self._left_out = 0
        lines = []
        while self._waiting and most > 0:
            line = self._waiting.popleft()
            self._size -= len(line)
            most -= len(line)
            lines.append(line.replace("\n", "\r\n"))
        self._screen.write_raw(notice + "".join(lines))
        self._screen.flush()


class _Printed:
    """A file that passes on whole lines."""

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
        """Do nothing: a line is passed on at its end."""

    def isatty(self) -> bool:
        return False
