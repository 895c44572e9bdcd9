"""The wait before the next try, for programs that talk to others outside."""

import random
from collections.abc import Callable

FIRST_S, MOST_S = 0.5, 60.0


def wait_s(tries: int, dice: Callable[[], float] = random.random) -> float:
    """Return how long to wait before the next try: longer each time, and never in step with other robots."""
    return float(min(MOST_S, FIRST_S * 2.0 ** min(tries, 30)) * (0.5 + 0.5 * dice()))
