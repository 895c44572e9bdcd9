"""The wait before the next try, for programs that connect to other machines."""

import random
from collections.abc import Callable

FIRST_S, MOST_S = 0.5, 60.0


def wait_s(tries: int, dice: Callable[[], float] = random.random) -> float:
    """Return the wait before the next try: longer each time, and random, so that robots do not try together."""
    return float(min(MOST_S, FIRST_S * 2.0 ** min(tries, 30)) * (0.5 + 0.5 * dice()))
