"""Numbers and names of motors and motions at faces to the outside, and changes of such rows."""

from typing import Annotated

from msgspec import Meta, Raw, Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.joints import motion_there
from lbr.messages.rows import Row
from lbr.messages.servos import ServoId
from lbr.messages.units import Name, NameOrNone

Counts = Annotated[int, Meta(ge=0, le=16383, description="the servo's own counts")]
"""Fourteen bits: what a servo's position has at most."""
Label = Annotated[str, Meta(min_length=1, max_length=40)]
Text = Annotated[str, Meta(max_length=200)]


class Motor(Row, frozen=True, kw_only=True):
    """Numbers, names and limits of servos for a face, such as an old phone app, in the servos' own counts. A face uses
    one layer. The limits of the joints always hold, too."""

    TABLE = "motor"
    KEY = ("layer", "id")
    ASCENDING = (("lowest", "highest"),)

    layer: Annotated[Name, "its name in a face's settings"]
    id: ServoId
    name: Annotated[Label, "for people"]
    description: Annotated[str, "for people"] = ""
    initial: Annotated[Counts, "a face's position before the first move"]
    lowest: Annotated[Counts, "a position beyond becomes the limit"]
    highest: Annotated[Counts, "see lowest"]
    rest: Annotated[Counts, "its position at rest"]
    inverted: Annotated[bool, "1: percentages count from its highest position"] = False
    builtin: Annotated[bool, "1: only an edit of the database changes it, never the network"] = False

    @property
    def full_name(self) -> str:
        """Return the servo and its layer."""
        return f"motor {self.id} of layer '{self.layer}'"


class Button(Row, frozen=True, kw_only=True):
    """Numbers and names of motions for a face, such as an old phone app. Several numbers may mean one motion."""

    TABLE = "button"
    KEY = ("id",)
    CHECKS = (motion_there,)

    id: Annotated[int, Meta(ge=0, le=9999), "the number"]
    name: Annotated[Label, "its name there; among equal names the lowest number counts"]
    button: Annotated[str, "the remote control's key"] = ""
    motion: Annotated[NameOrNone, "the motion; empty: only the controller is taken over"] = ""
    builtin: Annotated[bool, "1: only an edit of the database changes it, never the network"] = False

    @property
    def full_name(self) -> str:
        """Return the number."""
        return f"button {self.id}"


class EditCommand(Struct, frozen=True, kw_only=True):
    """Write these rows, by table, all or none; equal keys replace. Built-in rows stay.

    The sender's kind names the tables in `edits`. Parts of a row, such as key frames, come with it and replace its old
    parts. `create`: each row is new; otherwise each exists. `revision`: only if none has changed since. `by`: the
    person behind it.
    """

    rows: dict[str, Raw] = {}
    create: bool = False
    revision: int | None = None
    by: Annotated[str, Meta(max_length=80)] = ""


class EditReply(Struct, frozen=True, kw_only=True):
    """The result of an edit. `revision`: the newest in force, even after a refusal."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    revision: int = 0
