"""The browser in which tests look at pages."""

import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tests.support.waiting import HANG_S

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page, Playwright

WINDOWED = "chromium"
WINDOWLESS = "chromium-headless-shell"
"""Chromium without windows: with them, a page costs three times as much, most of it for the buttons around it."""
ELSEWHERE = "robot.test"
"""A name of this machine at which a browser counts as one on another machine."""
ARGUMENTS = ("--no-sandbox", "--disable-gpu", f"--host-resolver-rules=MAP {ELSEWHERE} 127.0.0.1")
AGAIN_MS = 20


def start(playwright: "Playwright", *more: str) -> "Browser":
    """Start the one without windows where it is installed, or else Chromium; with `more` arguments instead of the usual."""
    _be_patient()
    program = shutil.which(WINDOWLESS) or shutil.which(WINDOWED)
    return playwright.chromium.launch(executable_path=program, args=list(more or ARGUMENTS))


def start_windowed(playwright: "Playwright", home: Path | None = None) -> "Browser":
    """Start Chromium as persons have it, for what the one without windows lacks."""
    _be_patient()
    return playwright.chromium.launch(**windowed(home))


def _be_patient() -> None:
    from playwright.sync_api import expect

    expect.set_options(timeout=HANG_S * 1000)


def windowed(home: Path | None, *more: str) -> dict[str, Any]:
    """Say how Chromium is launched with `more` arguments; what it keeps of certificates is below `home`, if one is given."""
    env = {**os.environ, **({"XDG_DATA_HOME": str(home)} if home else {})}
    return {"executable_path": shutil.which(WINDOWED), "args": [*ARGUMENTS, *more], "env": env}


def within(page: "Page", true: Callable[[], Any], s: float = HANG_S) -> bool:
    """Return whether something comes true while the page goes on."""
    end = time.monotonic() + s
    while time.monotonic() < end:
        if true():
            return True
        page.wait_for_timeout(AGAIN_MS)
    return bool(true())
