"""What faces to the outside number and name motors and motions by, and changes of such rows."""

from collections.abc import Iterator
from typing import Annotated

from msgspec import Meta, Raw, Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.joints import motion_there
from lbr.messages.rows import Fault, Others, Row
from lbr.messages.servos import ServoId
from lbr.messages.units import Name, NameOrNone

Counts = Annotated[int, Meta(ge=0, le=16383, description="the servo's own counts")]
"""Fourteen bits: what a servo's position has at most."""
Label = Annotated[str, Meta(min_length=1, max_length=40)]
Text = Annotated[str, Meta(max_length=200)]


def _bounds(row: "Motor", _: Others) -> Iterator[Fault]:
    if not row.lowest < row.highest:
        yield "highest", f"{row.highest} is not above lowest, {row.lowest}"


class Motor(Row, frozen=True, kw_only=True):
    """A servo as one layer of a face to the outside numbers, names and limits it, in the servo's own counts."""

    TABLE = "motor"
    KEY = ("layer", "id")
    CHECKS = (_bounds,)

    layer: Name
    id: ServoId
    name: Label
    description: str = ""
    initial: Counts
    lowest: Counts
    highest: Counts
    rest: Counts
    inverted: bool = False
    builtin: bool = False

    @property
    def told(self) -> str:
        """Which servo of which layer."""
        return f"motor {self.id} of layer '{self.layer}'"


class Button(Row, frozen=True, kw_only=True):
    """A number and a name for a motion; of no motion, for taking the controller over."""

    TABLE = "button"
    KEY = ("id",)
    CHECKS = (motion_there,)

    id: Annotated[int, Meta(ge=0, le=9999)]
    name: Label
    button: str = ""
    motion: NameOrNone = ""
    builtin: bool = False

    @property
    def told(self) -> str:
        """Return which number."""
        return f"button {self.id}"


class EditCommand(Struct, frozen=True, kw_only=True):
    """Write these rows, by table, all or none: new ones, or in the place of those with the same key. Built-in ones
    stay.

    Which tables, the kind of who asks says in `edits`; parts of a row, such as key frames, come with it, and are then
    all that it has. `create`: none of them may be there yet; otherwise all of them must. `revision`: only if none of
    them has changed since that revision. `by` is who wants it.
    """

    rows: dict[str, Raw] = {}
    create: bool = False
    revision: int | None = None
    by: Annotated[str, Meta(max_length=80)] = ""


class EditReply(Struct, frozen=True, kw_only=True):
    """What became of it; `revision` is the newest of the rows in force, also where it was refused."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    revision: int = 0
