"""All that limits a motion: what the sensors see now, and what they saw. The strictest counts."""

from collections.abc import Iterable

from msgspec.structs import replace

from lbr.operations.drive import obstacle_memory, rules
from lbr.operations.drive.rules import Blocker, Limit
from lbr.operations.drive.state import State


def limit(state: State, wheels: tuple[float, float], now: float, blocked: Iterable[Blocker] = ()) -> Limit:
    """Return the strictest limit on this motion of the wheels; `blocked` is by what it was already stopped."""
    held = tuple(blocked)
    seen = rules.limit(state.settings, state.views, wheels, now, held, rules=state.sensors.rules)
    remembered = obstacle_memory.limit(state.memory, state.settings, wheels, now, held)
    strictest = remembered if remembered.scale < seen.scale else seen
    return replace(strictest, blocked=(*seen.blocked, *remembered.blocked))
