"""A full screen of text that is redrawn repeatedly."""

import time
from collections.abc import Callable
from typing import NoReturn

from rich.live import Live
from rich.text import Text

from lbr.console.outlet import unhurried


def redraw(frame: Callable[[], str], every_s: float) -> NoReturn:
    """Draw the text of `frame`, which may have colours, until Ctrl-C."""
    with unhurried() as outlet, Live(Text(""), screen=True, auto_refresh=False) as live:
        while True:
            text = frame()
            if not outlet.waiting:  # otherwise the terminal does not read, and would fall behind
                live.update(Text.from_ansi(text, no_wrap=True), refresh=True)
            time.sleep(every_s)
