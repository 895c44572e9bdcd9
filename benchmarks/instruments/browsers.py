"""A browser with the robot's page open: its stick, its processes, and the times of its moves; pages that only look."""

import select
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import psutil

from benchmarks.instruments import page_viewers
from tests.support import programs

PHONE: dict[str, Any] = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
READY = """() => {
  const stick = document.querySelector('.drive-stick:not([aria-disabled="true"])');
  return stick && document.querySelector('.linkdot[data-link="open"]') ? performance.now() : 0;
}"""
WATCH = """
localStorage.setItem("lbr.top", "0.4");
addEventListener("pointermove", (event) => { window.movedAt = performance.timeOrigin + event.timeStamp; }, true);
"""
LAUNCH = ["--no-sandbox", "--disable-gpu"]


def why_not() -> str:
    """Return why no browser can run here, or an empty text."""
    try:
        import playwright.sync_api  # noqa: F401 - an extra
    except ImportError:
        return "playwright is not installed"
    return "" if shutil.which("chromium") else "there is no program chromium"


class OpenPage:
    """The page in a browser, and a finger on its stick."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self._box: dict[str, float] = {}

    def look(self, url: str, within_s: float = 20.0) -> float:
        """Open the robot's page; return the milliseconds until it can be driven."""
        self.page.goto(url)
        return self.ready(within_s)

    def ready(self, within_s: float = 20.0) -> float:
        """Wait until it can be driven; return the milliseconds since it was opened."""
        took: float = self.page.wait_for_function(READY, timeout=within_s * 1000).json_value()
        stick = self.page.locator(".drive-stick")
        stick.scroll_into_view_if_needed()
        self._box = stick.bounding_box()
        return took

    def grip(self, right: float = 1.0, ahead: float = 0.0) -> None:
        """Put the finger on the stick's middle, and push it so far."""
        self.page.mouse.move(*self._at(0.0, 0.0))
        self.page.mouse.down()
        self.push(right, ahead)

    def push(self, right: float, ahead: float = 0.0) -> int:
        """Push the stick there; return the time before that, in nanoseconds of the monotonic clock."""
        before = time.monotonic_ns()
        self.page.mouse.move(*self._at(right, ahead))
        return before

    def release(self) -> None:
        """Lift the finger."""
        self.page.mouse.up()

    def moved_ns(self) -> int:
        """Return when the finger was moved last, by the browser's event, on the monotonic clock."""
        wall_ms: float = self.page.evaluate("window.movedAt")
        return int(wall_ms * 1e6) - (time.time_ns() - time.monotonic_ns())

    def _at(self, right: float, ahead: float) -> tuple[float, float]:
        box = self._box
        return (
            box["x"] + box["width"] * (0.5 + 0.36 * right),
            box["y"] + box["height"] * (0.5 - 0.36 * ahead),
        )


class Browsers:
    """Chromium, launched again whenever it was killed; by `prefix` on another machine."""

    def __init__(self, play: Any, folder: Path, prefix: tuple[str, ...] = ()) -> None:
        self.options: list[str] = []
        """Further options of the next browser."""
        self._play = play
        self._program = shutil.which("chromium") or ""
        if prefix:
            script = folder / "chromium"
            script.write_text(f'#!/bin/sh\nexec {" ".join(prefix)} {self._program} "$@"\n')
            script.chmod(0o700)
            self._program = str(script)
        self._browser: Any = None

    def open(self, **options: Any) -> OpenPage:
        """Open an empty page in a context of its own, on a phone's screen."""
        if self._browser is None:
            self._browser = self._play.chromium.launch(executable_path=self._program, args=[*LAUNCH, *self.options])
        context = self._browser.new_context(**{**PHONE, "ignore_https_errors": True, **options})
        context.add_init_script(WATCH)
        return OpenPage(context.new_page())

    def kill(self, processes: Sequence[psutil.Process]) -> None:
        """Kill it with all its processes."""
        for process in processes:
            _signal(process, signal.SIGKILL)

    def forget(self) -> None:
        """Note that it was killed."""
        with suppress(Exception):  # whatever is left of it
            self._browser.close()
        self._browser = None

    def close(self) -> None:
        """End it."""
        for process in self.processes():
            _signal(process, signal.SIGCONT)
        self.forget()

    @contextmanager
    def frozen(self, processes: Sequence[psutil.Process]) -> Iterator[None]:
        """Freeze all of it, like on a locked phone; it goes on at the end of a `with`."""
        try:
            for process in processes:
                _signal(process, signal.SIGSTOP)
            yield
        finally:
            for process in processes:
                _signal(process, signal.SIGCONT)

    def processes(self) -> list[psutil.Process]:
        """Return its processes, with the main one first."""
        return [one for one in psutil.Process().children(recursive=True) if _is_chromium(one)]


@contextmanager
def browsers(folder: Path, prefix: tuple[str, ...] = ()) -> Iterator[Browsers]:
    """Provide browsers for the time of a `with`."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        found = Browsers(play, folder, prefix)
        try:
            yield found
        finally:
            found.close()


@contextmanager
def viewers(url: str, tokens: Sequence[str], count: int, rate_hz: float) -> Iterator[list[float]]:
    """Let so many pages look for the time of a `with`, by these tokens in turns, as the server limits each.

    Yields a list that has frames a second of each afterwards.
    """
    popen = programs.start(
        [sys.executable, page_viewers.__file__, url, str(count), f"{rate_hz:g}", *tokens],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    found: list[float] = []
    try:
        assert popen.stdout is not None
        assert popen.stdout.readline().strip() == "open", "the pages were not let in"
        yield found
        found.append(float(popen.communicate()[0]))
    finally:
        popen.kill()
        popen.communicate()


def wait_for(true: Callable[[], object], within_s: float) -> bool:
    """Return whether a condition becomes true in time."""
    end = time.monotonic() + within_s
    while not true():
        if time.monotonic() > end:
            return False
        select.select([], [], [], 0.002)
    return True


def _is_chromium(process: psutil.Process) -> bool:
    try:
        return "chrom" in process.name()
    except psutil.Error:
        return False


def _signal(process: psutil.Process, number: int) -> None:
    with suppress(psutil.Error):
        process.send_signal(number)
