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
AGAIN_S, SELDOM_S = 0.005, 0.05
LATER = 0.2
"""A look costs the robot an answer: the longer it was waited, the later comes the next, by this part of the time."""


def until(look: Callable[[], T], what: str = "", *, limit_s: float = HANG_S) -> T:
    """Look again and again until it is truthy, and return that; fail with the last look."""
    begun = time.monotonic()
    while not (seen := look()):
        waited_s = time.monotonic() - begun
        if waited_s > limit_s:
            raise AssertionError(f"not within {limit_s:g} s: {what or look}; last seen {seen!r}")
        select.select([], [], [], min(max(AGAIN_S, LATER * waited_s), SELDOM_S))
    return seen
