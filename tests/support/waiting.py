"""Waiting for what must come. The only bound is that of a hang: how long a busy machine takes proves nothing."""

import select
import time
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")

HANG_S = 30.0
"""Longer than two busy loops beside the tests hold up anything that comes at all."""
STOPS_S = 3.0
"""A stop that is lost would leave the robot moving for longer: to the wall, or to the end of its goal."""
AGAIN_S = 0.005


def until(look: Callable[[], T], what: str = "", *, limit_s: float = HANG_S) -> T:
    """Look again and again until it is truthy, and return that; fail with the last look."""
    end = time.monotonic() + limit_s
    while not (seen := look()):
        if time.monotonic() > end:
            raise AssertionError(f"not within {limit_s:g} s: {what or look}; last seen {seen!r}")
        select.select([], [], [], AGAIN_S)
    return seen
