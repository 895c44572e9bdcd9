"""The declarations of robots in packages: `Robot` declares rows, launch profiles and a body; `registry` finds them."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lbr.robot.declaration import Robot

__all__ = ["Robot"]


def __getattr__(name: str) -> Any:
    """Import `Robot` on request: a search for robots needs no declaration."""
    if name != "Robot":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from lbr.robot.declaration import Robot  # noqa: PLC0415

    return Robot
