"""The result of a check of `lbr doctor`."""

from typing import Literal

from msgspec import Struct

Level = Literal["good", "hint", "bad"]


class Finding(Struct, frozen=True, kw_only=True):
    """The state of one thing: `bad` keeps a robot from running, a `hint` may; `do` is the cure to type."""

    about: str
    level: Level
    text: str
    do: str = ""
