"""The things in a room: boxes and cylinders, one by one, and the furnished room that a world has by default."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

Length = Annotated[float, Meta(gt=0.0, le=1000.0, description="metres")]
Place = Annotated[float, Meta(ge=-1000.0, le=1000.0, description="metres")]
Height = Annotated[float, Meta(ge=0.0, le=1000.0, description="metres above the floor")]
Colour = Annotated[str, Meta(pattern="^#[0-9a-f]{6}$(?!\\n)", description="as in #8a5a3c")]

GREY = "#607068"


class BoxSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Something in the room: its centre, its full size, and its turn anticlockwise. A cylinder stands upright,
    `length_m` thick. A thing that is not `solid` is only visible."""

    name: str
    x_m: Place
    y_m: Place
    length_m: Length
    width_m: Length
    height_m: Length = 1.5
    yaw_rad: float = 0.0
    bottom_m: Height = 0.0
    kind: Literal["box", "cylinder"] = "box"
    colour: Colour = GREY
    solid: bool = True


def post(
    name: str, at: tuple[float, float], thick_m: float, height_m: float, colour: str, bottom_m: float = 0.0
) -> BoxSettings:
    """Return an upright cylinder."""
    return BoxSettings(
        name=name,
        x_m=at[0],
        y_m=at[1],
        length_m=thick_m,
        width_m=thick_m,
        height_m=height_m,
        bottom_m=bottom_m,
        kind="cylinder",
        colour=colour,
    )


def on_legs(top: BoxSettings, leg_m: float) -> tuple[BoxSettings, ...]:
    """Return a plate with the four legs that carry it, `leg_m` thick; the plate is not turned."""
    ahead, aside = top.length_m / 2 - leg_m, top.width_m / 2 - leg_m
    corners = ((ahead, aside), (-ahead, aside), (-ahead, -aside), (ahead, -aside))
    legs = (
        post(f"{top.name} leg {number}", (top.x_m + x, top.y_m + y), leg_m, top.bottom_m, colour=top.colour)
        for number, (x, y) in enumerate(corners, start=1)
    )
    return (top, *legs)


_PAINT, _WOOD, _DARK, _CLOTH, _LEAF, _CLAY = "#aaa393", "#a8763e", "#5a4632", "#3f5f8a", "#3e7d45", "#b4623e"

_WALLS = (
    BoxSettings(name="north wall", x_m=4.55, y_m=0.0, length_m=0.1, width_m=5.2, height_m=2.4, colour=_PAINT),
    BoxSettings(name="south wall", x_m=-1.55, y_m=0.0, length_m=0.1, width_m=5.2, height_m=2.4, colour=_PAINT),
    BoxSettings(name="west wall", x_m=1.5, y_m=2.55, length_m=6.2, width_m=0.1, height_m=2.4, colour=_PAINT),
    BoxSettings(name="east wall", x_m=0.15, y_m=-2.55, length_m=3.5, width_m=0.1, height_m=2.4, colour=_PAINT),
    BoxSettings(name="wall by the door", x_m=3.7, y_m=-2.55, length_m=1.8, width_m=0.1, height_m=2.4, colour=_PAINT),
    BoxSettings(
        name="lintel", x_m=2.35, y_m=-2.55, length_m=0.9, width_m=0.1, bottom_m=2.0, height_m=0.4, colour=_PAINT
    ),
    BoxSettings(name="hall", x_m=2.35, y_m=-3.45, length_m=2.2, width_m=0.1, height_m=2.4, colour=_PAINT),
    BoxSettings(name="hall south", x_m=1.3, y_m=-3.0, length_m=0.1, width_m=0.8, height_m=2.4, colour=_PAINT),
    BoxSettings(name="hall north", x_m=3.4, y_m=-3.0, length_m=0.1, width_m=0.8, height_m=2.4, colour=_PAINT),
)

_FURNITURE = (
    BoxSettings(name="cupboard", x_m=3.9, y_m=-2.2, length_m=1.0, width_m=0.5, colour=_WOOD),
    BoxSettings(name="crate", x_m=1.1, y_m=-1.7, length_m=0.4, width_m=0.4, height_m=0.5, yaw_rad=0.5, colour=_WOOD),
    BoxSettings(name="shelf", x_m=-0.9, y_m=2.3, length_m=0.8, width_m=0.3, colour=_DARK),
    BoxSettings(
        name="sofa", x_m=4.05, y_m=1.75, length_m=0.85, width_m=1.4, bottom_m=0.06, height_m=0.4, colour=_CLOTH
    ),
    BoxSettings(
        name="sofa back", x_m=4.36, y_m=1.75, length_m=0.22, width_m=1.4, bottom_m=0.46, height_m=0.4, colour=_CLOTH
    ),
    BoxSettings(name="rug", x_m=1.9, y_m=0.0, length_m=1.8, width_m=1.2, height_m=0.005, colour="#9c4a4a", solid=False),
    *on_legs(
        BoxSettings(
            name="table", x_m=2.4, y_m=1.7, length_m=1.1, width_m=0.7, bottom_m=0.72, height_m=0.03, colour=_WOOD
        ),
        0.06,
    ),
    *on_legs(
        BoxSettings(
            name="chair", x_m=2.4, y_m=1.2, length_m=0.42, width_m=0.42, bottom_m=0.43, height_m=0.04, colour=_DARK
        ),
        0.03,
    ),
    BoxSettings(
        name="chair back", x_m=2.4, y_m=1.0, length_m=0.42, width_m=0.03, bottom_m=0.47, height_m=0.45, colour=_DARK
    ),
    post("plant pot", (4.1, -1.35), 0.32, 0.35, colour=_CLAY),
    post("plant", (4.1, -1.35), 0.5, 0.7, bottom_m=0.45, colour=_LEAF),
    post("lamp foot", (-1.2, -2.2), 0.3, 0.03, colour=_DARK),
    post("lamp", (-1.2, -2.2), 0.03, 1.5, bottom_m=0.03, colour=_DARK),
    post("bin", (0.95, 2.3), 0.28, 0.35, colour=_CLAY),
)

ROOM = (*_WALLS, *_FURNITURE)
"""A room of 6 by 5 m with a door to a hall. The robot starts at the origin with 4.5 m of free space ahead."""
