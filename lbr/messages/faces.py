"""What faces to the outside number and name motors and motions by, and changes of such rows."""

from collections.abc import Callable, Iterable
from typing import Annotated, Any, TypeVar

from msgspec import Meta, Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.joints import Motion
from lbr.messages.units import Name

Counts = Annotated[int, Meta(ge=0, le=16383, description="the servo's own counts")]
Label = Annotated[str, Meta(min_length=1, max_length=40)]
Text = Annotated[str, Meta(max_length=200)]

R = TypeVar("R", bound=Struct)


class Motor(Struct, frozen=True, kw_only=True):
    """A row of the table `motor`: a servo as one layer has it."""

    layer: Name
    id: Annotated[int, Meta(ge=0, le=253)]
    name: Label
    description: Text = ""
    initial: Counts
    lowest: Counts
    highest: Counts
    rest: Counts
    inverted: bool = False
    builtin: bool = False


class Button(Struct, frozen=True, kw_only=True):
    """A row of the table `button`: a number and a name for a motion; of no motion, for taking the controller over."""

    id: Annotated[int, Meta(ge=0, le=9999)]
    name: Label
    button: Text = ""
    motion: Name | None = None
    builtin: bool = False


class EditCommand(Struct, frozen=True, kw_only=True):
    """Write these rows, all or none: new ones, or in the place of those with the same key. Built-in ones stay.

    `create`: none of them may be there yet; otherwise all of them must. `revision`: only if none of them has changed
    since that revision. `by` is who wants it.
    """

    motors: tuple[Motor, ...] = ()
    motions: tuple[Motion, ...] = ()
    buttons: tuple[Button, ...] = ()
    create: bool = False
    revision: int | None = None
    by: Annotated[str, Meta(max_length=80)] = ""


class EditReply(Struct, frozen=True, kw_only=True):
    """What became of it; `revision` is the newest of the rows in force, also where it was refused."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
    revision: int = 0


class FaceRows(Struct, frozen=True, kw_only=True):
    """The rows that an edit may touch, in the order of their keys."""

    motors: tuple[Motor, ...] = ()
    motions: tuple[Motion, ...] = ()
    buttons: tuple[Button, ...] = ()

    def edited(self, edit: EditCommand) -> "FaceRows":
        """Return the rows as they are once an edit is written."""
        return FaceRows(
            motors=_merged(self.motors, edit.motors, motor_key),
            motions=_merged(self.motions, edit.motions, motion_key),
            buttons=_merged(self.buttons, edit.buttons, button_key),
        )


def motor_key(motor: Motor) -> tuple[str, int]:
    """Return what tells a motor from all others."""
    return motor.layer, motor.id


def motion_key(motion: Motion) -> str:
    """Return what tells a motion from all others."""
    return motion.name


def button_key(button: Button) -> int:
    """Return what tells a button from all others."""
    return button.id


def _merged(rows: Iterable[R], new: Iterable[R], key: Callable[[R], Any]) -> tuple[R, ...]:
    found = {key(row): row for row in (*rows, *new)}
    return tuple(found[name] for name in sorted(found))
