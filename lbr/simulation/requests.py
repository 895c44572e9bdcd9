"""Requests to the world while it runs."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.messages.schema import JsonObject
from lbr.messages.units import Name, NameOrNone

Metres = Annotated[float, Meta(ge=-1000.0, le=1000.0, description="metres")]
Extent = Annotated[float, Meta(gt=0.0, le=10.0, description="metres")]
Pixels = Annotated[int, Meta(ge=100, le=4000)]


class PlugRequest(Struct, frozen=True, kw_only=True):
    """Emulate one more device of this robot; the executive sends it for a new row."""

    device: Name
    type: str
    address: str
    settings: JsonObject = {}


class FaultRequest(Struct, frozen=True, kw_only=True):
    """Set one fault of an emulated device; `value` null: as before. `unplug` and `replug` need only true."""

    device: Name
    name: str
    value: bool | float | str | tuple[str, ...] | None = True


class FaultReply(Struct, frozen=True, kw_only=True):
    """The result, and the faults of that device now; or why nothing changed."""

    accepted: bool
    reason: str = ""
    faults: JsonObject = {}


class PlaceRequest(Struct, frozen=True, kw_only=True):
    """Put a box into the world, or move the one of that name: its middle, full size, turn anticlockwise."""

    x_m: Metres
    y_m: Metres
    name: Annotated[str, Meta(min_length=1, max_length=40)] = "obstacle"
    length_m: Extent = 0.3
    width_m: Extent = 0.3
    height_m: Extent = 1.0
    yaw_rad: Annotated[float, Meta(ge=-7.0, le=7.0)] = 0.0


class RemoveRequest(Struct, frozen=True, kw_only=True):
    """Remove a placed thing."""

    name: Annotated[str, Meta(min_length=1, max_length=40)] = "obstacle"


class ThingsReply(Struct, frozen=True, kw_only=True):
    """The result, and the things placed now; or why nothing changed."""

    accepted: bool
    reason: str = ""
    things: tuple[str, ...] = ()


class BallRequest(Struct, frozen=True, kw_only=True):
    """Put a ball of the world elsewhere; a missing coordinate is its row's, all missing: as it began."""

    name: Annotated[str, Meta(min_length=1, max_length=40)] = "ball"
    x_m: Metres | None = None
    y_m: Metres | None = None
    z_m: Metres | None = None
    gone: bool = False


class BallReply(Struct, frozen=True, kw_only=True):
    """The result; or why nothing changed."""

    accepted: bool
    reason: str = ""


class HandRequest(Struct, frozen=True, kw_only=True):
    """Have a hand move a humanoid's joint there, and hold it, as a person moves a limp one. `gone`: it releases all."""

    joint: NameOrNone = ""
    angle_deg: Annotated[float, Meta(ge=-360.0, le=360.0, description="degrees from the joint's zero")] = 0.0
    gone: bool = False


class PictureRequest(Struct, frozen=True, kw_only=True):
    """Draw the world into a new PNG file, at `path` in an existing folder, or below `$LBR_HOME/pictures`.

    A room is seen from above, a humanoid from its front and left.
    """

    path: str = ""
    width_px: Pixels = 900
    height_px: Pixels = 750


class PictureReply(Struct, frozen=True, kw_only=True):
    """The file of the picture."""

    accepted: bool
    reason: str = ""
    path: str = ""


class PickUpRequest(Struct, frozen=True, kw_only=True):
    """Put the humanoid back as it began: on its feet in a helper's hand, which holds it until its servos have torque.

    A humanoid that begins at rest rests again, unless a servo has torque: then a hand holds it until all have.
    """


class PickUpReply(Struct, frozen=True, kw_only=True):
    """The result, in words."""

    accepted: bool
    reason: str = ""
