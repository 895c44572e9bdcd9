"""Robots that packages bring: rows, launch profiles and bodies, declared by one object that their component names."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lbr.robots.robot import Robot

__all__ = ["Robot"]


def __getattr__(name: str) -> Any:
    """Import `Robot` when it is asked for: the components of robots are below this package, and need none."""
    if name != "Robot":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from lbr.robots.robot import Robot  # noqa: PLC0415

    return Robot
