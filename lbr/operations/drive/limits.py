"""All limits of a motion, by present and remembered sights; the strictest counts."""

from collections.abc import Iterable

from msgspec.structs import replace

from lbr.operations.drive import obstacle_memory, rules
from lbr.operations.drive.command import Sides
from lbr.operations.drive.rules import Blocker, Limit
from lbr.operations.drive.state import State


def limit(state: State, sides: Sides, now: float, blocked: Iterable[Blocker] = ()) -> Limit:
    """Return the strictest limit on this motion; `blocked` has the causes by which it was already stopped."""
    held, (left, right, aside) = tuple(blocked), sides
    seen = rules.limit(state.settings, state.views, (left, right), now, held, aside, rules=state.sensors.rules)
    remembered = obstacle_memory.limit(state.memory, state.settings, (left, right), now, held, aside)
    strictest = remembered if remembered.scale < seen.scale else seen
    return replace(strictest, blocked=(*seen.blocked, *remembered.blocked))
