"""How long a page may be silent while what it holds goes on. Pure.

A hand on a stick says where to go all the time, and without it the way ends nowhere. A motion of joints through key frames
ends by itself, where its rows say, and a page that draws its progress slowly has nothing to tell: it only has to be there.
"""

from collections.abc import Mapping
from typing import Any

from lbr.messages.description import CommandDescription, Schema
from lbr.messages.joints import JointsCommand, PlayCommand

SILENT_S = 0.25
"""Wheels are to stand within 0.4 s of a page's last word: this, a round, and the way to the motors."""
PLAYING_S = 2.0
"""A phone that draws a body without a graphics card, or loads a view meanwhile, says nothing for a second at times."""


def silent_s(command: CommandDescription | None, message: Mapping[str, Any]) -> float:
    """Return for how long a page may say nothing while a command of its goes on: longer where that ends by itself."""
    name = _type_of(command.schema) if command is not None else ""
    if name == PlayCommand.__name__:
        return PLAYING_S
    through = message.get("frames") and not any(message.get(more) for more in ("stay", "append", "join"))
    return PLAYING_S if name == JointsCommand.__name__ and through else SILENT_S


def _type_of(schema: Schema) -> str:
    """Return the name of the message that a schema is of."""
    title, ref = schema.get("title"), schema.get("$ref")
    return str(title or str(ref or "").rpartition("/")[2])
