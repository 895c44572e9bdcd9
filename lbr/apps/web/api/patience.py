"""The silence of a page in which its motion goes on. Pure.

A hand on a stick says where to go all the time, and without it the way ends nowhere. A turn, a drive to a range or for
a time, and a motion of joints through key frames end by themselves: their page has nothing to tell and only has to be
there.
"""

from collections.abc import Mapping

from lbr.messages.description import CommandDescription, Schema
from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand
from lbr.messages.joints import JointsCommand, PlayCommand

SILENT_S = 0.25
"""Wheels are to stand within 0.4 s of a page's last word: this, a round, and the way to the motors."""
BOUNDED_S = 2.0
"""A phone that draws a body without a graphics card, loads a view, or has a bad radio, says nothing for a second at
times."""
_END_BY_THEMSELVES = frozenset(message.__name__ for message in (PlayCommand, TurnCommand, HeadingCommand))


def silent_s(command: CommandDescription | None, message: Mapping[str, object]) -> float:
    """Return for how long a page may say nothing while a command of its goes on: longer where that ends by itself."""
    name = type_of(command.schema) if command is not None else ""
    if name == DriveCommand.__name__:
        bounded = any(message.get(bound) for bound in ("distance_cm", "range_cm", "interval_s"))
    elif name == JointsCommand.__name__:
        bounded = bool(message.get("frames")) and not any(message.get(more) for more in ("stay", "append", "join"))
    else:
        bounded = name in _END_BY_THEMSELVES
    return BOUNDED_S if bounded else SILENT_S


def type_of(schema: Schema) -> str:
    """Return the name of the message that a schema is of."""
    title, ref = schema.get("title"), schema.get("$ref")
    return str(title or str(ref or "").rpartition("/")[2])
