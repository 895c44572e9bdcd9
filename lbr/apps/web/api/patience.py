"""The longest silence of a page during its motion. Pure.

A stick steers without end, so its page must send all the time. Turns, drives to a range or for a time, and motions of
joints through key frames end by themselves. Their page only has to stay connected.
"""

from collections.abc import Mapping

from lbr.messages.description import CommandDescription, Schema
from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand
from lbr.messages.joints import JointsCommand, PlayCommand

SILENT_S = 0.25
"""Wheels must stand within 0.4 s of a page's last message: this silence, a round, and the way to the motors."""
BOUNDED_S = 2.0
"""A phone that draws a body without a graphics card, loads a view, or has a bad radio is at times silent for a
second."""
_END_BY_THEMSELVES = frozenset(message.__name__ for message in (PlayCommand, TurnCommand, HeadingCommand))


def silent_s(command: CommandDescription | None, message: Mapping[str, object]) -> float:
    """Return how long a page may be silent during its command; longer if the command ends by itself."""
    name = type_of(command.schema) if command is not None else ""
    if name == DriveCommand.__name__:
        bounded = any(message.get(bound) for bound in ("distance_cm", "range_cm", "interval_s"))
    elif name == JointsCommand.__name__:
        bounded = bool(message.get("frames")) and not any(message.get(more) for more in ("stay", "append", "join"))
    else:
        bounded = name in _END_BY_THEMSELVES
    return BOUNDED_S if bounded else SILENT_S


def type_of(schema: Schema) -> str:
    """Return the name of a schema's message."""
    title, ref = schema.get("title"), schema.get("$ref")
    return str(title or str(ref or "").rpartition("/")[2])
