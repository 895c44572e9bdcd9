"""A picture of text that fills the terminal and is drawn again and again."""

import time
from collections.abc import Callable
from typing import NoReturn

from rich.live import Live
from rich.text import Text

from lbr.console.outlet import unhurried


def redraw(frame: Callable[[], str], every_s: float) -> NoReturn:
    """Draw what `frame` returns until Ctrl-C; it may hold colours."""
    with unhurried() as outlet, Live(Text(""), screen=True, auto_refresh=False) as live:
        while True:
            text = frame()
            if not outlet.waiting:  # else the terminal is not read, and would only fall behind
                live.update(Text.from_ansi(text, no_wrap=True), refresh=True)
            time.sleep(every_s)
