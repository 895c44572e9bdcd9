"""What can be asked of the world while it runs."""

from typing import Annotated, Any

from msgspec import Meta, Struct

from lbr.messages.units import Name

Pixels = Annotated[int, Meta(ge=100, le=4000)]


class FaultRequest(Struct, frozen=True, kw_only=True):
    """Set one fault of one emulated device; `value` null puts it back. `unplug` and `replug` need no more than true."""

    device: Name
    name: str
    value: bool | float | str | tuple[str, ...] | None = True


class FaultReply(Struct, frozen=True, kw_only=True):
    """The faults of that device as they now are, or why nothing changed."""

    accepted: bool
    reason: str = ""
    faults: dict[str, Any] = {}


class PictureRequest(Struct, frozen=True, kw_only=True):
    """Draw the world from above into a PNG file: at `path`, or below `$LBR_HOME/pictures`."""

    path: str = ""
    width_px: Pixels = 900
    height_px: Pixels = 750


class PictureReply(Struct, frozen=True, kw_only=True):
    """Where the picture is."""

    accepted: bool
    reason: str = ""
    path: str = ""
