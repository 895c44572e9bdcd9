"""Shell completions for the commands that read recordings."""

from contextlib import suppress

import click
from click.shell_completion import CompletionItem

from lbr import home
from lbr.apps.recorder.recording import shelf
from lbr.commands.completing import items
from lbr.errors import LbrError


def complete_recording(_context: click.Context, _parameter: click.Parameter, begun: str) -> list[CompletionItem]:
    """Return the kept incidents and the recordings."""
    with suppress(LbrError, OSError):
        shelves = [shelf.Shelf(home.home(), robot) for robot in shelf.robots(home.home())]
        kept = [(one.path.name, one.why.text if one.why else "") for here in shelves for one in here.incidents()]
        made = [(path.stem, "a recording") for here in shelves for path in here.recordings()]
        return items(begun, kept + made)
    return []
